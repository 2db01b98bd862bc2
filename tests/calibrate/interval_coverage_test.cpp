// How often intervals hold the truth: many cheap repeats of models whose best parameters need no
// search. That a search finds the ends of intervals is told by tests of whole calibrations; the
// share of a thousand such intervals is counted by bench_calibration_coverage.
#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/tools/minima.hpp>

#include "calibrate/knowledge/uncertainty.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr int repeats = 200;
constexpr int least = 180;  // of these, of each parameter
constexpr int most = 198;   // where replicates are not so few that intervals must be wider

using boost::math::cdf;
using Binomial = boost::math::binomial_distribution<>;

TEST(IntervalCoverageTest, HasPower) {
  // The test itself: what holds 95 or 93 % passes, what holds 85 % or nearly always fails
  EXPECT_LT(cdf(Binomial(repeats, 0.95), least - 1), 0.002);
  EXPECT_LT(cdf(Binomial(repeats, 0.93), least - 1), 0.05);
  EXPECT_GT(cdf(Binomial(repeats, 0.85), least - 1), 0.96);
  EXPECT_GT(1.0 - cdf(Binomial(repeats, 0.998), most), 0.9);
  EXPECT_LT(1.0 - cdf(Binomial(repeats, 0.97), most), 0.02);
}

// Two parameters of which each moves numbers of its own, so that their best are found one by one.
using At = std::function<Evaluation(double between, double wall)>;

struct Held {
  int between = 0, wall = 0;

  void count(const Problem& problem, double truth, const At& at) {
    const auto lowest = [&](const auto& along) {
      constexpr double reach = 0.15;
      constexpr int bits = 12;
      return boost::math::tools::brent_find_minima(along, truth - reach, truth + reach, bits).first;
    };
    const double best_between = lowest([&](double value) { return at(value, truth).objective; });
    const double best_wall =
        lowest([&](double value) { return at(best_between, value).objective; });
    const std::array all = {
        at(best_between, best_wall), at(truth, best_wall), at(best_between, truth)};
    const PooledChance chance = pool_chance(*problem.calibrated, all, 0.0);
    between += excess_over(*problem.calibrated, all[0], all[1], chance).is_compatible();
    wall += excess_over(*problem.calibrated, all[0], all[2], chance).is_compatible();
  }

  void expect_as_asked(bool are_few) const {
    testing::Test::RecordProperty("between", between);
    testing::Test::RecordProperty("wall", wall);
    for (const int held : {between, wall}) {
      EXPECT_GE(held, least);
      if (!are_few) {
        EXPECT_LE(held, most);
      }
    }
  }
};

class IntervalCoverage : public testing::TestWithParam<int> {};  // replicates of a condition

TEST_P(IntervalCoverage, OfTracksIsAsAsked) {
  constexpr double noise = 0.001;  // m
  const ParameterSet truth = toy::parameters(0.3, 0.3, 0.7);
  Held held;
  for (std::uint64_t repeat = 0; repeat < repeats; ++repeat) {
    const Problem problem =
        toy::problem({.parameters = truth, .noise = noise}, GetParam(), 100 + repeat);
    const auto seeds = make_seeds(repeat, "simulations", CalibrationOptions{}.search_seeds);
    held.count(problem, 0.3, [&](double between, double wall) {
      Evaluation evaluation{.parameters = toy::parameters(between, wall, 0.7)};
      for (const std::uint64_t seed : seeds)
        evaluation.runs.push_back(
            toy::compared(problem, toy::run(evaluation.parameters, noise, seed)));
      evaluation.objective = problem.calibrated->objective(evaluation.runs);
      return evaluation;
    });
  }
  held.expect_as_asked(GetParam() < 5);
}

INSTANTIATE_TEST_SUITE_P(OfReplicates,
                         IntervalCoverage,
                         testing::Values(2, 3, 5, 10),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace graintruth::calibrate
