#include "tracking/event/event.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace graintruth::tracking {
namespace {

HeightRecord sinking(
    double onset, double speed, double noise, int frames, double rate, unsigned seed) {
  HeightRecord record;
  std::mt19937 generator(seed);
  std::normal_distribution<double> error(0.0, noise);
  for (int k = 0; k < frames; ++k) {
    const double time = k / rate;
    record.time.push_back(time);
    record.height.push_back(0.003 + speed * std::max(0.0, time - onset) + error(generator));
  }
  return record;
}

RC_GTEST_PROP(Onset, IsFoundToAFractionOfAFrame, ()) {
  const double onset = *rc::gen::inRange(100, 800) / 1000.0;
  const HeightRecord record =
      sinking(onset, -0.046, 5.0e-5, 120, 50.0, *rc::gen::inRange(1U, 1000U));
  const auto event = fit_onset(record, -0.046);
  RC_ASSERT(event.has_value());
  RC_ASSERT(std::abs(event->time - onset) < 0.004);
  RC_ASSERT(std::abs(event->time - onset) < 6.0 * event->uncertainty);
}

TEST(Onset, SurvivesMissingAndWildHeights) {
  HeightRecord record = sinking(0.31, -0.046, 3.0e-5, 100, 50.0, 4);
  for (std::size_t k = 5; k < 100; k += 9)
    record.height[k] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 7; k < 100; k += 17) record.height[k] += 0.01;
  const auto event = fit_onset(record, -0.046);
  ASSERT_TRUE(event);
  EXPECT_NEAR(event->time, 0.31, 0.004);
}

TEST(Onset, IsNotFoundWhereNothingMoves) {
  EXPECT_FALSE(fit_onset(sinking(100.0, -0.046, 3.0e-5, 100, 50.0, 4), -0.046));
}

TEST(Onset, IsNotFoundWhereTheFilmBeginsTooLate) {
  EXPECT_FALSE(fit_onset(sinking(-0.5, -0.046, 3.0e-5, 100, 50.0, 4), -0.046));
}

}  // namespace
}  // namespace graintruth::tracking
