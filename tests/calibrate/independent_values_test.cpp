// How many values profiles are worth whose neighbours vary together.
#include "calibrate/compare/independent_values.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>

namespace graintruth::calibrate {
namespace {

// Profiles of `values` columns, `alike` neighbours each the same, with scatters from 1 to 2.
Repeats profiles(std::size_t repeats, std::size_t values, std::size_t alike, double mean = 0.0) {
  boost::random::mt19937_64 generator(7);
  boost::random::normal_distribution<double> normal;
  Repeats all(repeats, std::vector<double>(values));
  for (std::vector<double>& one : all) {
    double drawn = 0.0;
    for (std::size_t i = 0; i < values; ++i) {
      if (i % alike == 0) drawn = normal(generator);
      one[i] = mean + drawn * (1.0 + static_cast<double>(i) / static_cast<double>(values));
    }
  }
  return all;
}

double worth(const std::vector<Repeats>& groups) { return independent_values(groups); }

// Of p values and n degrees of freedom tr C^2 is p + p^2/n in the mean: 1/(1/p + 1/n) are found.
TEST(IndependentValues, AreAllWhereEachVariesByItself) {
  EXPECT_NEAR(worth({profiles(201, 40, 1)}), 1.0 / (1.0 / 40 + 1.0 / 200), 1.5);
}

TEST(IndependentValues, AreAsManyAsThereAreGroupsOfColumnsThatVaryTogether) {
  EXPECT_NEAR(worth({profiles(201, 40, 4)}), 1.0 / (1.0 / 10 + 1.0 / 200), 0.5);
  EXPECT_NEAR(worth({profiles(5, 40, 40)}), 1.0, 1e-12);
}

TEST(IndependentValues, AreNoMoreThanTheRepeatsTell) {
  const double of_three = worth({profiles(3, 40, 1)});
  EXPECT_GT(of_three, 1.0);
  EXPECT_LE(of_three, 2.0);
}

TEST(IndependentValues, DoNotDependOnWhatGroupsDifferBy) {
  EXPECT_NEAR(worth({profiles(50, 12, 1), profiles(50, 12, 1, 100.0)}),
              worth({profiles(50, 12, 1), profiles(50, 12, 1)}),
              1e-6);
}

TEST(IndependentValues, LeaveOutWhatNeverVariesOrIsNotAlwaysKnown) {
  Repeats more = profiles(50, 12, 1);
  const double before = worth({more});
  for (std::vector<double>& one : more) one.insert(one.end(), {3.0, 1.0});
  more[4].back() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(worth({more}), before, 1e-12);
}

TEST(IndependentValues, AreOneWhereNothingTellsOfThem) {
  EXPECT_EQ(worth({}), 1.0);
  EXPECT_EQ(worth({{{1.0, 2.0}}}), 1.0);
  EXPECT_EQ(worth({{{1.0, 2.0}, {1.0, 2.0}}}), 1.0);
}

}  // namespace
}  // namespace graintruth::calibrate
