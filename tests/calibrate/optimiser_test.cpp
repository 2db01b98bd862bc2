#include "calibrate/search/optimiser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graintruth::calibrate {
namespace {

double rosenbrock(const std::vector<double>& unit) {
  const double x = 4.0 * unit[0] - 2.0;
  const double y = 4.0 * unit[1] - 2.0;
  return std::pow(1.0 - x, 2) + 100.0 * std::pow(y - x * x, 2);
}

TEST(Minimise, FindsTheMinimumOfAKnownFunction) {
  const OptimiserSummary summary =
      minimise(rosenbrock, {0.2, 0.8}, {.max_evaluations = 5000, .tolerance = 1e-9});
  EXPECT_NEAR(summary.best[0], 0.75, 1e-3);
  EXPECT_NEAR(summary.best[1], 0.75, 1e-3);
  EXPECT_LT(summary.objective, 1e-6);
}

TEST(Minimise, WorksForOneParameterAndAtTheEdge) {
  const OptimiserSummary summary = minimise(
      [](const auto& x) { return x[0]; }, {0.97}, {.max_evaluations = 200, .tolerance = 1e-6});
  EXPECT_NEAR(summary.best[0], 0.0, 1e-5);
}

TEST(Minimise, NeverLeavesTheCubeAndKeepsItsBudget) {
  int calls = 0;
  minimise(
      [&](const std::vector<double>& point) {
        ++calls;
        for (const double coordinate : point) {
          EXPECT_GE(coordinate, 0.0);
          EXPECT_LE(coordinate, 1.0);
        }
        return -point[0] - point[1];
      },
      {0.99, 0.5},
      {.max_evaluations = 25, .tolerance = 1e-12});
  EXPECT_LE(calls, 25);
}

TEST(Minimise, ReportsTheBestThatItSaw) {
  double lowest = 1e300;
  const OptimiserSummary summary = minimise(
      [&](const std::vector<double>& point) {
        // Rough on purpose, so that the last point is not the best.
        const double value = std::pow(point[0] - 0.4, 2) + 0.05 * std::sin(300.0 * point[0]);
        lowest = std::min(lowest, value);
        return value;
      },
      {0.9},
      {.max_evaluations = 40, .tolerance = 1e-6});
  EXPECT_EQ(summary.objective, lowest);
}

TEST(Minimise, PassesOnWhatTheObjectiveThrows) {
  int calls = 0;
  const auto objective = [&](const std::vector<double>&) -> double {
    if (++calls == 5) throw std::runtime_error("the simulator is gone");
    return 1.0 / calls;
  };
  EXPECT_THROW(minimise(objective, {0.5, 0.5}, {.max_evaluations = 100}), std::runtime_error);
  EXPECT_EQ(calls, 5);
}

}  // namespace
}  // namespace graintruth::calibrate
