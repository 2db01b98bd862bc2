#include "calibrate/search/surrogate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/knowledge/sensitivity.h"

namespace graintruth::calibrate {
namespace {

double smooth(const UnitPoint& x) {
  return std::sin(3.0 * x[0]) + 2.0 * (x[1] - 0.4) * (x[1] - 0.4);
}

Surrogate fitted(const std::vector<UnitPoint>& points, double noise) {
  std::vector<double> values;
  for (const UnitPoint& point : points) values.push_back(smooth(point));
  return Surrogate(points, values, std::vector<double>(points.size(), noise));
}

TEST(LowDiscrepancyPoints, FillTheCubeMoreEvenlyThanChance) {
  const auto points = low_discrepancy_points(64, 2, 5);
  int cells[4][4] = {};
  for (const UnitPoint& point : points) {
    ASSERT_GE(point[0], 0.0);
    ASSERT_LT(point[0], 1.0);
    ++cells[static_cast<int>(4 * point[0])][static_cast<int>(4 * point[1])];
  }
  for (const auto& row : cells) {
    for (const int count : row) EXPECT_NEAR(count, 4, 2);
  }
  EXPECT_EQ(low_discrepancy_points(8, 3, 1), low_discrepancy_points(8, 3, 1));
  EXPECT_NE(low_discrepancy_points(8, 3, 1), low_discrepancy_points(8, 3, 2));
}

TEST(Surrogate, PredictsASmoothFunctionBetweenItsPoints) {
  const Surrogate surrogate = fitted(low_discrepancy_points(40, 2, 1), 1e-4);
  for (const UnitPoint& place : {UnitPoint{0.31, 0.62}, UnitPoint{0.7, 0.2}, UnitPoint{0.5, 0.5}}) {
    EXPECT_NEAR(
        surrogate.predict(std::vector<UnitPoint>(1, place)).front().mean, smooth(place), 0.02);
  }
  EXPECT_LT(surrogate.leave_one_out_error(), 0.1 * surrogate.value_spread());
}

TEST(Surrogate, IsSureNearItsPointsOnly) {
  const Surrogate surrogate =
      fitted({{0.1, 0.1}, {0.2, 0.1}, {0.1, 0.2}, {0.3, 0.3}, {0.2, 0.4}, {0.4, 0.1}}, 1e-3);
  const auto predictions = surrogate.predict(std::vector<UnitPoint>{{0.1, 0.1}, {0.95, 0.95}});
  EXPECT_LT(predictions[0].standard_deviation, 0.3 * predictions[1].standard_deviation);
}

TEST(Surrogate, AddsWhatIsKnownToTheLogarithmItPredicts) {
  const Surrogate own =
      fitted({{0.1, 0.1}, {0.2, 0.1}, {0.1, 0.2}, {0.3, 0.3}, {0.2, 0.4}, {0.4, 0.1}}, 1e-3);
  const Surrogate sum = own.plus([](const UnitPoint& place) { return 3.0 * place[0]; });
  const std::vector<UnitPoint> places = {{0.8, 0.7}, {0.0, 0.15}};
  const auto alone = own.predict(places);
  const auto both = sum.predict(places);
  EXPECT_NEAR(both[0].mean, std::log(std::exp(alone[0].mean) + 2.4), 1e-12);
  EXPECT_LT(both[0].standard_deviation, alone[0].standard_deviation);
  EXPECT_NEAR(both[1].mean, alone[1].mean, 1e-12);
  EXPECT_EQ(sum.roughness(), own.roughness());
}

// f = a x0 + b x1 over the unit square: S_i = T_i = a_i^2 / (a^2 + b^2), and x2 has none.
TEST(TotalSensitivities, AreThoseOfALinearFunction) {
  const std::vector<UnitPoint> points = low_discrepancy_points(60, 3, 1);
  std::vector<double> values;
  for (const UnitPoint& point : points) values.push_back(2.0 * point[0] + point[1]);
  const auto total =
      total_sensitivities(Surrogate(points, values, std::vector<double>(60, 1e-4)), 3);
  ASSERT_EQ(total.size(), 3U);
  EXPECT_NEAR(total[0], 0.8, 0.03);
  EXPECT_NEAR(total[1], 0.2, 0.03);
  EXPECT_LT(total[2], 0.02);
}

}  // namespace
}  // namespace graintruth::calibrate
