#include "app/scenes/hopper_measures.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <numbers>

namespace graintruth::app {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

// 4000 grains at random in a hopper 1 m wide; those outside of the lines that leave the floor at
// 0.2 m from the middle at this angle creep, the others run; one in twenty does as its neighbours
// do not.
sim::State sheared_bed(double angle, std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::uniform_01<double> share;
  sim::State state;
  for (int i = 0; i < 4000; ++i) {
    const double x = share(generator) - 0.5, z = 0.4 * share(generator);
    const bool is_inside = std::abs(x) < 0.2 + z / std::tan(angle);
    const bool is_odd = share(generator) < 0.05;
    const double speed = is_inside != is_odd ? 0.5 + 0.5 * share(generator) : 0.1;
    state.position.emplace_back(x, 0.0, z);
    state.velocity.emplace_back(0.0, 0.0, -speed);
  }
  return state;
}

TEST(ShearBand, HasTheAngleOfTheLineBetweenSlowAndFast) {
  for (const double angle : {55.0, 70.0, 90.0, 100.0}) {
    const std::vector<sim::State> states = {sheared_bed(angle * degree, 1),
                                            sheared_bed(angle * degree, 2)};
    const auto found = shear_band_angle(states, {.height = 0.3, .row_height = 0.03});
    ASSERT_TRUE(found.has_value()) << angle;
    EXPECT_NEAR(*found / degree, angle, 1.5);
  }
}

TEST(ShearBand, IsNotInventedWhereAllMovesAlike) {
  sim::State state = sheared_bed(55.0 * degree, 3);
  for (sim::Vec3& velocity : state.velocity) velocity = {0.0, 0.0, -1.0};
  EXPECT_FALSE(shear_band_angle(std::span(&state, 1), {.height = 0.3, .row_height = 0.03}));
  state.velocity.front() = {0.0, 0.0, -10.0};  // all but one slow: one row at most
  EXPECT_FALSE(shear_band_angle(std::span(&state, 1), {.height = 0.3, .row_height = 0.03}));
}

TEST(Heap, HasTheSlopeOfItsSurfaceWhateverLiesOnIt) {
  boost::random::mt19937_64 generator(5);
  boost::random::uniform_01<double> share;
  for (const double slope : {0.0, 12.0, 30.0}) {
    std::vector<sim::Vec3> centres;
    for (int i = 0; i < 20000; ++i) {
      const double x = share(generator) - 0.5;
      const double top = 0.4 - std::abs(x) * std::tan(slope * degree);
      centres.emplace_back(x, 0.0, top * share(generator));
    }
    centres.emplace_back(0.2, 0.0, 0.7);  // still in flight
    const auto found = heap_slope(centres, 0.5, 0.02);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found / degree, slope, 1.0);
  }
  EXPECT_FALSE(heap_slope({}, 0.5, 0.02));
}

}  // namespace
}  // namespace graintruth::app
