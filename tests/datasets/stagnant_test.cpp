#include "datasets/imports/stagnant.h"

#include <gtest/gtest.h>

#include <cmath>

namespace graintruth::datasets {
namespace {

constexpr double diameter = 0.012, width = 0.12, orifice = 0.06;

// A column's places from the floor up: `still` of them, `holes`, again as many still.
StagnantMap with_hole(std::size_t still, std::size_t holes, Ground above) {
  StagnantMap map = make_stagnant_map(width, 0.12, diameter);
  for (std::size_t row = 0; row < 2 * still + holes; ++row)
    if (row < still || row >= still + holes) map.at(0, row) = Ground::still;
  map.at(0, 2 * still + holes) = above;
  return map;
}

TEST(Stagnant, SpeedIsATenthOfADiameterInTheTimeOfFallingByOne) {
  const double time = std::sqrt(2.0 * diameter / 9.81);
  EXPECT_NEAR(stagnant_speed(diameter, 9.81) * time, 0.1 * diameter, 1e-15);
}

TEST(Stagnant, PlacesFillTheBin) {
  const StagnantMap map = make_stagnant_map(width, 0.12, diameter);
  ASSERT_EQ(map.x.size(), 20U);
  ASSERT_EQ(map.z.size(), 80U);
  EXPECT_NEAR(map.x.front(), -0.057, 1e-12);
  EXPECT_NEAR(map.x.back(), 0.057, 1e-12);
  EXPECT_NEAR(map.z.front(), 0.00075, 1e-12);
  EXPECT_NEAR(map.z.back(), 0.11925, 1e-12);
}

TEST(Stagnant, HeightsPassOverSmallHolesButNotOverWhatMoves) {
  const double row = 0.0015;
  EXPECT_NEAR(stagnant_heights(with_hole(8, 0, Ground::moving), orifice)[0], 16 * row, 1e-12);
  EXPECT_NEAR(stagnant_heights(with_hole(8, 4, Ground::moving), orifice)[0], 20 * row, 1e-12);
  EXPECT_NEAR(stagnant_heights(with_hole(8, 5, Ground::empty), orifice)[0], 8 * row, 1e-12);
  StagnantMap map = with_hole(8, 2, Ground::empty);
  map.at(0, 9) = Ground::moving;
  EXPECT_NEAR(stagnant_heights(map, orifice)[0], 8 * row, 1e-12);
  EXPECT_EQ(stagnant_heights(map, orifice)[1], 0.0);
  EXPECT_TRUE(std::isnan(stagnant_heights(map, orifice)[10]));
}

TEST(Stagnant, OverlapIsIntersectionOverUnion) {
  const StagnantMap tall = with_hole(8, 0, Ground::empty), low = with_hole(4, 0, Ground::empty);
  EXPECT_EQ(stagnant_overlap(tall, low), 0.5);
  EXPECT_EQ(stagnant_overlap(low, low), 1.0);
  const StagnantMap nothing = make_stagnant_map(width, 0.12, diameter);
  EXPECT_EQ(stagnant_overlap(nothing, nothing), 1.0);
  EXPECT_EQ(stagnant_overlap(nothing, low), 0.0);
}

TEST(Stagnant, OverlapOfAreasBelowLinesLeavesOutWhatIsNotKnown) {
  const double nan = std::nan("");
  const std::vector<double> a = {0.02, nan, 0.04, 0.0}, b = {0.04, 0.1, 0.02, 0.0};
  EXPECT_NEAR(stagnant_overlap(a, b), 0.04 / 0.08, 1e-12);
  EXPECT_EQ(stagnant_overlap(a, a), 1.0);
  EXPECT_EQ(stagnant_overlap(std::vector<double>{0.0}, std::vector<double>{0.0}), 1.0);
  EXPECT_TRUE(std::isnan(stagnant_overlap(std::vector<double>{}, b)));
}

}  // namespace
}  // namespace graintruth::datasets
