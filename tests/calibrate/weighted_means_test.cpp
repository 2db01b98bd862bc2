// Means and spreads of channels over repeats, directions among them.
#include "calibrate/compare/weighted_means.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "calibrate/observables/track_results.h"

namespace graintruth::calibrate {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double unseen = std::numeric_limits<double>::quiet_NaN();

const ChannelShape shape = shape_of_tracks(1);

Channel one_pose(double x, double z, double angle) { return {.values = {x, z, angle}}; }

std::vector<Spread> spreads(const std::vector<Channel>& repeats) {
  return spreads_of(pointers_to(repeats), shape);
}

TEST(SpreadsOf, AreThoseOfTheSample) {
  const Spread spread = spreads({one_pose(1, 0, 0), one_pose(2, 0, 0), one_pose(6, 0, 0)}).front();
  EXPECT_DOUBLE_EQ(spread.mean, 3.0);
  EXPECT_DOUBLE_EQ(spread.standard_deviation, std::sqrt(7.0));  // (4 + 1 + 9) / 2
  EXPECT_EQ(spread.count, 3);
}

TEST(SpreadsOf, AnglesOnBothSidesOfPiAreNeighbours) {
  const Spread spread = spreads({one_pose(0, 0, 0.01), one_pose(0, 0, pi - 0.01)})[2];
  EXPECT_NEAR(difference(Difference::half_turn, spread.mean, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(spread.standard_deviation, 0.01 * std::sqrt(2.0), 1e-12);
}

TEST(SpreadsOf, UnseenRepeatsAreLeftOut) {
  const Spread spread = spreads({one_pose(1, 1, 1), one_pose(unseen, unseen, unseen)}).front();
  EXPECT_EQ(spread.count, 1);
  EXPECT_EQ(spread.mean, 1.0);
  EXPECT_TRUE(std::isnan(spread.standard_deviation));
}

TEST(WeightedMeans, AWeightCountsARepeatSeveralTimes) {
  const std::vector<Channel> repeats = {
      one_pose(1, 1, 0.1), one_pose(2, 3, 0.3), one_pose(9, 9, 0.9)};
  const std::vector<double> weighted =
      WeightedMeans(pointers_to(repeats), shape).mean(std::vector<int>{1, 2, 0});
  const std::vector<Spread> plain = spreads({repeats[0], repeats[1], repeats[1]});
  for (std::size_t i = 0; i < weighted.size(); ++i) EXPECT_NEAR(weighted[i], plain[i].mean, 1e-14);
}

TEST(WeightedMeans, OfEqualWeightsAreTheMeans) {
  const std::vector<Channel> repeats = {
      one_pose(1, 1, 3.1), one_pose(unseen, unseen, unseen), one_pose(9, 9, 0.1)};
  const WeightedMeans means(pointers_to(repeats), shape);
  const std::vector<double> weighted = means.mean(std::vector<int>{1, 1, 1});
  EXPECT_EQ(weighted, means.mean());
  const std::vector<Spread> plain = spreads(repeats);
  for (std::size_t i = 0; i < weighted.size(); ++i) EXPECT_EQ(weighted[i], plain[i].mean);
}

RC_GTEST_PROP(DifferenceOfDirections,
              IsWithinAQuarterTurnAndBlindToHalfTurns,
              (int a_mrad, int b_mrad)) {
  const double a = 1e-3 * (a_mrad % 100000);
  const double b = 1e-3 * (b_mrad % 100000);
  const double plain = difference(Difference::half_turn, a, b);
  RC_ASSERT(std::abs(plain) <= pi / 2 + 1e-9);
  // At a quarter turn exactly, both signs are right.
  const double turned = difference(Difference::half_turn, a + pi, b);
  RC_ASSERT(std::abs(std::remainder(turned - plain, pi)) < 1e-9);
}

TEST(RmsPosition, IsARootOfAMeanSquare) {
  EXPECT_DOUBLE_EQ(rms_position({0, 0, 0, 1, 1, 0}, {3, 4, 0, 1, 1, 0}, shape),
                   std::sqrt(25.0 / 2.0));
}

}  // namespace
}  // namespace graintruth::calibrate
