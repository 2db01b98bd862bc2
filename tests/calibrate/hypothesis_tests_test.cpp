#include "calibrate/compare/hypothesis_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/read_rows.h"

namespace graintruth::calibrate {
namespace {

using tests::number;

void expect_relative(double value, double expected, double tolerance) {
  EXPECT_NEAR(value, expected, tolerance * std::abs(expected));
}

void expect_is(const TTest& test, const tests::Row& row) {
  expect_relative(test.t, number(row, "t"), 1e-12);
  expect_relative(test.freedom, number(row, "df"), 1e-10);
  expect_relative(test.p, number(row, "p_two_sided"), 1e-10);
  expect_relative(test.lower, number(row, "ci95_low"), 1e-10);
  expect_relative(test.upper, number(row, "ci95_high"), 1e-10);
}

TEST(TTests, OfStudentsSleepData) {
  std::vector<double> first, second;
  for (const tests::Row& row :
       tests::read_rows(tests::bundled_reference("t_tests/sleep_data.csv"))) {
    first.push_back(number(row, "group1"));
    second.push_back(number(row, "group2"));
  }
  ASSERT_EQ(first.size(), 10U);
  const auto results = tests::read_rows(tests::bundled_reference("t_tests/sleep_results.csv"));
  ASSERT_EQ(results.size(), 3U);
  expect_is(welch_test(summarise(first), summarise(second)), results[0]);
  expect_is(pooled_test(summarise(first), summarise(second)), results[1]);
  expect_is(paired_test(first, second), results[2]);
}

// An infinite number of degrees of freedom is a known variance; one component alone is Student's; a
// sum is bounded by what its smallest and all degrees of freedom together would give.
TEST(HalfWidth, PoolsDegreesOfFreedom) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<VarianceComponent> known = {{4.0, infinity}};
  EXPECT_NEAR(half_width_95(known), 2.0 * 1.959963984540054, 1e-12);
  const std::vector<VarianceComponent> one = {{9.0, 4.0}, {0.0, 5.0}};
  EXPECT_NEAR(half_width_95(one), 3.0 * student_t_quantile(0.975, 4.0), 1e-12);
  const std::vector<VarianceComponent> equal = {{1.0, 4.0}, {1.0, 4.0}};
  EXPECT_NEAR(satterthwaite_freedom(equal), 8.0, 1e-12);
  const std::vector<VarianceComponent> mixed = {{2.0, 4.0}, {0.5, 5.0}, {0.1, infinity}};
  EXPECT_GT(satterthwaite_freedom(mixed), 4.0);
  EXPECT_LT(satterthwaite_freedom(mixed), 9.0);
  EXPECT_EQ(half_width_95({}), 0.0);
}

TEST(TTests, QuantilesOfStudentsT) {
  const auto rows = tests::read_rows(tests::bundled_reference("t_tests/t_quantiles.csv"));
  ASSERT_GT(rows.size(), 10U);
  for (const tests::Row& row : rows)
    expect_relative(
        student_t_quantile(number(row, "p"), number(row, "df")), number(row, "t"), 1e-10);
}

// Table 4.6: the thesis prints t = 0.14, P = 0.90.
TEST(TTests, OfTheThesissCoefficients) {
  const TTest test = welch_test({0.390, 0.0122, 5}, {0.386, 0.0631, 5});
  EXPECT_NEAR(test.t, 0.139, 5e-4);
  EXPECT_NEAR(test.p, 0.8956, 5e-5);
  // No difference was found, and yet a fifth of C would not have been seen.
  EXPECT_GT(test.upper, 0.08);
  EXPECT_FALSE(equivalence_test(test, 0.05 * 0.390).equivalent);
  EXPECT_TRUE(equivalence_test(test, 0.25 * 0.390).equivalent);
}

TEST(TTests, EquivalenceAgreesWithTheNinetyPercentInterval) {
  const TTest test = welch_test({10.0, 1.0, 12}, {10.4, 1.5, 9});
  const double reach = student_t_quantile(0.95, test.freedom) * test.standard_error;
  const double bound = std::abs(test.difference) + reach;
  EXPECT_TRUE(equivalence_test(test, 1.001 * bound).equivalent);
  EXPECT_FALSE(equivalence_test(test, 0.999 * bound).equivalent);
  EXPECT_NEAR(equivalence_test(test, bound).p, 0.05, 1e-9);
}

}  // namespace
}  // namespace graintruth::calibrate
