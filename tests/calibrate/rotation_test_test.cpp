// The rotation test against closed forms, and how often it is wrong.
#include "calibrate/knowledge/rotation_test.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <random>

namespace graintruth::calibrate {
namespace {

// Rows of one normal law, whose values have `common` of their variance in common.
Eigen::MatrixXd draw(int rows, int columns, double common, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd made(rows, columns);
  for (int row = 0; row < rows; ++row) {
    const double shared = std::sqrt(common) * normal(random);
    for (int column = 0; column < columns; ++column)
      made(row, column) = shared + std::sqrt(1.0 - common) * normal(random);
  }
  return made;
}

// With one column: t = y_1 / sqrt(sum of the other squares / (n - 1)).
TEST(RotationTest, IsStudentsTestWithOneColumn) {
  std::mt19937_64 random(1);
  for (const int rows : {2, 3, 5, 10}) {
    for (int draws = 0; draws < 5; ++draws) {
      const Eigen::MatrixXd y = draw(rows, 1, 0.0, random);
      const double t = y(0, 0) / std::sqrt((y.squaredNorm() - y(0, 0) * y(0, 0)) / (rows - 1.0));
      const boost::math::students_t law(rows - 1);
      EXPECT_NEAR(rotation_test(y), 2.0 * boost::math::cdf(law, -std::abs(t)), 1e-6) << rows;
    }
  }
}

TEST(RotationTest, DoesNotDependOnUnits) {
  std::mt19937_64 random(2);
  Eigen::MatrixXd y = draw(5, 3, 0.3, random);
  const double chance = rotation_test(y);
  y.col(1) *= 1e6;
  EXPECT_NEAR(rotation_test(y), chance, 1e-7);
}

TEST(RotationTest, TellsNothingOfNothing) {
  EXPECT_EQ(rotation_test(Eigen::MatrixXd::Zero(4, 3)), 1.0);
  EXPECT_EQ(rotation_test(Eigen::MatrixXd::Ones(1, 3)), 1.0);
  EXPECT_GT(rotation_test(Eigen::MatrixXd::Identity(4, 4)), 0.99);
}

// However many values there are, and however strongly they hang together: 2000 draws each, at 5 %
// within four standard errors.
TEST(RotationTest, IsWrongAsOftenAsItSays) {
  std::mt19937_64 random(3);
  constexpr int draws = 2000;
  constexpr double level = 0.05;
  for (const auto& [columns, common] : {std::pair(1, 0.0),
                                        std::pair(3, 0.0),
                                        std::pair(20, 0.0),
                                        std::pair(20, 0.5),
                                        std::pair(20, 0.95)}) {
    int wrong = 0;
    for (int i = 0; i < draws; ++i)
      wrong += rotation_test(draw(4, columns, common, random)) < level ? 1 : 0;
    EXPECT_NEAR(
        wrong / static_cast<double>(draws), level, 4.0 * std::sqrt(level * (1.0 - level) / draws))
        << columns << " columns, " << common;
  }
}

}  // namespace
}  // namespace graintruth::calibrate
