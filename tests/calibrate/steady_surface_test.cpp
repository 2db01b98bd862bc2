// A surface whose slope first drifts, then wavers about a mean that is known.
#include "calibrate/observables/steady_surface.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <numbers>

namespace graintruth::calibrate {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double dt = 0.02;  // s

Situation situation() {
  Situation made;
  made.particle.diameter = 0.004;
  datasets::SeenOutline& seen = made.rig.seen_outline.emplace();
  seen.from_x = -0.05;
  seen.to_x = 0.05;
  seen.floor_z = -0.055;
  seen.drum = datasets::SeenOutline::Drum{.centre = {0.0, 0.0}, .radius = 0.055};
  return made;
}

// A straight surface through the axis, of this slope (rad) at every moment.
datasets::Outline outline_of(const std::vector<double>& slopes) {
  datasets::Outline made;
  made.column = columns_of(situation());
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    made.time.push_back(dt * static_cast<double>(i));
    for (const double x : made.column) made.height.push_back(x * std::tan(slopes[i]));
  }
  return made;
}

// Each forgets the last by a share of `memory`: correlation time dt (1 + m)/(1 - m), standard
// deviation `sd`.
std::vector<double> wavering(std::size_t count, double mean, double sd, double memory) {
  boost::random::mt19937_64 random(5);
  boost::random::normal_distribution<double> normal;
  std::vector<double> slopes;
  double now = normal(random);
  for (std::size_t i = 0; i < count; ++i) {
    slopes.push_back(mean + sd * now);
    now = memory * now + std::sqrt(1.0 - memory * memory) * normal(random);
  }
  return slopes;
}

TEST(SteadySurface, HasMeanSpreadAndErrorOfWhatWavers) {
  const auto surface =
      steady_surface(outline_of(wavering(2000, -40.0 * degree, degree, 0.8)), situation());
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->correlation_time, dt * 9.0, 0.3 * dt * 9.0);
  EXPECT_NEAR(surface->slope_sd, degree, 0.1 * degree);
  const double error = degree * std::sqrt(9.0 / 2000.0);
  EXPECT_NEAR(surface->slope_error, error, 0.3 * error);
  EXPECT_NEAR(surface->slope, -40.0 * degree, 3.0 * error);
  EXPECT_FALSE(surface->is_drifting);
  for (std::size_t i = 0; i < surface->x.size(); ++i)
    EXPECT_NEAR(surface->mean[i], -surface->x[i] * std::tan(40.0 * degree), 2e-4);
}

TEST(SteadySurface, LeavesOutTheWayThere) {
  std::vector<double> slopes = wavering(400, -40.0 * degree, degree, 0.5);
  for (std::size_t i = 0; i < 100; ++i)
    slopes[i] += 30.0 * degree * (1.0 - static_cast<double>(i) / 100.0);
  const auto surface = steady_surface(outline_of(slopes), situation());
  ASSERT_TRUE(surface);
  EXPECT_GT(surface->first, 80U);
  EXPECT_LT(surface->first, 150U);
  EXPECT_NEAR(surface->slope, -40.0 * degree, 0.5 * degree);
  EXPECT_FALSE(surface->is_drifting);
}

TEST(SteadySurface, TellsThatItNeverIsSteady) {
  std::vector<double> slopes = wavering(200, -40.0 * degree, 0.2 * degree, 0.5);
  for (std::size_t i = 0; i < slopes.size(); ++i)
    slopes[i] += 20.0 * degree * static_cast<double>(i) / 200.0;
  const auto surface = steady_surface(outline_of(slopes), situation());
  ASSERT_TRUE(surface);
  EXPECT_TRUE(surface->is_drifting);
}

// Beyond the bed there is the drum's empty part, not a floor at its lowest point.
TEST(SteadySurface, EndsWhereNoGrainIsSeen) {
  datasets::Outline outline = outline_of(wavering(100, -40.0 * degree, degree, 0.5));
  for (std::size_t moment = 0; moment < outline.time.size(); ++moment)
    for (std::size_t i = 0; i < outline.column.size(); ++i)
      if (outline.column[i] > 0.04) outline.height[outline.index(moment, i)] = std::nan("");
  const auto surface = steady_surface(outline, situation());
  ASSERT_TRUE(surface);
  for (std::size_t i = 0; i < surface->x.size(); ++i)
    EXPECT_EQ(std::isnan(surface->mean[i]), surface->x[i] > 0.04) << surface->x[i];
}

TEST(SteadySurface, NeedsTwentyMoments) {
  EXPECT_FALSE(steady_surface(outline_of(wavering(19, 0.0, degree, 0.0)), situation()));
}

}  // namespace
}  // namespace graintruth::calibrate
