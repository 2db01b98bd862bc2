#include "calibrate/measure.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

namespace graintruth::calibrate {
namespace {

constexpr double pi = std::numbers::pi;

datasets::Trajectories one_pose(double x, double z, double angle) {
  datasets::Trajectories tracks = datasets::make_trajectories(1, 1, false);
  tracks.poses[0] = {x, z, angle};
  return tracks;
}

TEST(Measure, MeanAndSpreadAreThoseOfTheSample) {
  const std::vector<datasets::Trajectories> repeats = {
      one_pose(1, 0, 0), one_pose(2, 0, 0), one_pose(6, 0, 0)};
  const Spread spread = measure(repeats).spreads[0][0];
  EXPECT_DOUBLE_EQ(spread.mean, 3.0);
  EXPECT_DOUBLE_EQ(spread.standard_deviation, std::sqrt(7.0));  // (4 + 1 + 9) / 2
  EXPECT_EQ(spread.count, 3);
}

TEST(Measure, AnglesOnBothSidesOfPiAreNeighbours) {
  const std::vector<datasets::Trajectories> repeats = {one_pose(0, 0, 0.01),
                                                       one_pose(0, 0, pi - 0.01)};
  const Spread spread = measure(repeats).spreads[0][2];
  EXPECT_NEAR(difference(Quantity::angle, spread.mean, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(spread.standard_deviation, 0.01 * std::sqrt(2.0), 1e-12);
}

TEST(WeightedMeans, AWeightCountsARepeatSeveralTimes) {
  const std::vector<datasets::Trajectories> repeats = {
      one_pose(1, 1, 0.1), one_pose(2, 3, 0.3), one_pose(9, 9, 0.9)};
  const std::vector<datasets::Trajectories> doubled = {repeats[0], repeats[1], repeats[1]};
  const datasets::Pose weighted =
      WeightedMeans(repeats).mean(std::vector<int>{1, 2, 0}).poses.front();
  const datasets::Pose plain = mean_track(measure(doubled)).poses.front();
  for (const Quantity quantity : quantities)
    EXPECT_NEAR(value_of(weighted, quantity), value_of(plain, quantity), 1e-14);
}

TEST(WeightedMeans, OfEqualWeightsAreTheMeans) {
  const std::vector<datasets::Trajectories> repeats = {
      one_pose(1, 1, 3.1), datasets::make_trajectories(1, 1, false), one_pose(9, 9, 0.1)};
  const datasets::Pose weighted =
      WeightedMeans(repeats).mean(std::vector<int>{1, 1, 1}).poses.front();
  const datasets::Pose plain = mean_track(measure(repeats)).poses.front();
  for (const Quantity quantity : quantities)
    EXPECT_EQ(value_of(weighted, quantity), value_of(plain, quantity));
}

TEST(Measure, UnseenRepeatsAreLeftOut) {
  const std::vector<datasets::Trajectories> repeats = {one_pose(1, 1, 1),
                                                       datasets::make_trajectories(1, 1, false)};
  const Spread spread = measure(repeats).spreads[0][0];
  EXPECT_EQ(spread.count, 1);
  EXPECT_EQ(spread.mean, 1.0);
  EXPECT_TRUE(std::isnan(spread.standard_deviation));
}

RC_GTEST_PROP(Difference,
              OfAnglesIsWithinAQuarterTurnAndBlindToHalfTurns,
              (int a_mrad, int b_mrad)) {
  const double a = 1e-3 * (a_mrad % 100000);
  const double b = 1e-3 * (b_mrad % 100000);
  const double plain = difference(Quantity::angle, a, b);
  RC_ASSERT(std::abs(plain) <= pi / 2 + 1e-9);
  // At a quarter turn exactly, both signs are right.
  const double turned = difference(Quantity::angle, a + pi, b);
  RC_ASSERT(std::abs(std::remainder(turned - plain, pi)) < 1e-9);
}

TEST(RmsPosition, IsARootOfAMeanSquare) {
  datasets::Trajectories a = datasets::make_trajectories(1, 2, false);
  datasets::Trajectories b = a;
  a.poses = {{0, 0, 0}, {1, 1, 0}};
  b.poses = {{3, 4, 0}, {1, 1, 0}};
  EXPECT_DOUBLE_EQ(rms_position(a, b), std::sqrt(25.0 / 2.0));
}

}  // namespace
}  // namespace graintruth::calibrate
