#include "tracking/film/clock.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

namespace graintruth::tracking {
namespace {

constexpr double pixel = 1.0e-3;  // m
constexpr int particles = 8, frames = 60;

// Where particle p is at an instant, counted in frames: some at rest, some pushed, some falling
// from an instant of their own and stopped by the floor.
datasets::Pose place(int particle, double instant) {
  const double x = 0.05 * particle;
  if (particle < 2) return {x, 0.0, 0.0};
  if (particle < 5) return {x + 1.2e-3 * instant, 0.1 - 0.4e-3 * particle * instant, 0.0};
  const double falling = std::max(0.0, instant - 8.0 - 2.0 * particle);
  return {x, std::max(0.0, 0.3 - 0.5 * 0.4e-3 * falling * falling), 0.0};
}

datasets::Trajectories filmed_at(const std::vector<double>& instants) {
  datasets::Trajectories tracks = datasets::make_trajectories(instants.size(), particles, true);
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0.0, 0.05 * pixel);
  for (std::size_t k = 0; k < instants.size(); ++k) {
    tracks.time[k] = static_cast<double>(k);
    for (int p = 0; p < particles; ++p) {
      datasets::Pose pose = place(p, instants[k]);
      pose.x += noise(generator);
      pose.z += noise(generator);
      tracks.poses[tracks.index(k, static_cast<std::size_t>(p))] = pose;
    }
  }
  return tracks;
}

std::vector<double> even() {
  std::vector<double> instants;
  for (int k = 0; k < frames; ++k) instants.push_back(k);
  return instants;
}

TEST(Clock, FindsNothingInAnEvenFilm) {
  const ClockFaults faults = find_clock_faults(filmed_at(even()), pixel);
  EXPECT_TRUE(faults.repeated.empty());
  EXPECT_TRUE(faults.jumps.empty());
  EXPECT_TRUE(describe(faults, {}).empty());
}

RC_GTEST_PROP(Clock, FindsAPictureThatIsMissing, ()) {
  const int at = *rc::gen::inRange(4, frames - 4);
  std::vector<double> instants = even();
  instants.erase(instants.begin() + at);
  const ClockFaults faults = find_clock_faults(filmed_at(instants), pixel);
  RC_ASSERT(faults.jumps == std::vector<int>{at});
  RC_ASSERT(faults.repeated.empty());
  RC_ASSERT(describe(faults, {}).size() == 1U);
}

RC_GTEST_PROP(Clock, FindsAPictureThatIsShownAgain, ()) {
  const int at = *rc::gen::inRange(4, frames - 4);
  std::vector<double> instants = even();
  const bool instead_of_another = *rc::gen::arbitrary<bool>();
  if (instead_of_another)
    instants[static_cast<std::size_t>(at)] -= 1.0;
  else
    instants.insert(instants.begin() + at, instants[static_cast<std::size_t>(at - 1)]);
  const ClockFaults faults = find_clock_faults(filmed_at(instants), pixel);
  RC_ASSERT(faults.repeated == std::vector<int>{at});
  RC_ASSERT(faults.jumps.empty());
  RC_ASSERT(describe(faults, {}).size() == 1U);
  RC_ASSERT(describe(faults, {at}).empty());  // the reader told already
}

}  // namespace
}  // namespace graintruth::tracking
