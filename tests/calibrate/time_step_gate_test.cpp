#include "calibrate/time_step_gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calibrate/toy_experiment.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

// The toy's tracks move with 0.2 fraction^2; `gain` makes that larger.
Simulator drifting(double gain, double noise) {
  return [=](const SimulationRequest& request) {
    ParameterSet shifted = request.parameters;
    shifted.friction_particle_particle +=
        gain * request.time_step_fraction * request.time_step_fraction;
    return SimulatedRun{.trajectories = toy::run(shifted, noise, request.seed),
                        .time_step = request.time_step_fraction};
  };
}

TimeStepChoice choose(const Simulator& simulator, const Problem& problem) {
  const TemporaryFolder folder;
  Journal journal(folder / "j.db");
  Ensemble ensemble({Scene{problem.hash, simulator}}, journal, problem.comparison, 2);
  const std::vector<ParameterSet> places = {{0.3, 0.3, 0.7}, {0.1, 0.4, 0.7}};
  return choose_time_step(ensemble, places, 0.4, make_seeds(1, "gate", 8));
}

TEST(ChooseTimeStep, TakesTheLargestWhereTheStepDoesNotMatter) {
  const TimeStepChoice choice = choose(drifting(0.0, 0.002), toy::problem({}, 5, 1));
  EXPECT_TRUE(choice.converged);
  EXPECT_DOUBLE_EQ(choice.fraction, 0.4);
}

TEST(ChooseTimeStep, TakesASmallerOneWhereItDoes) {
  const TimeStepChoice choice = choose(drifting(1.0, 1e-6), toy::problem({}, 5, 1));
  EXPECT_LT(choice.fraction, 0.4);
  EXPECT_GT(choice.discretisation_error, 0.0);
}

TEST(ChooseTimeStep, SaysWhenEvenTheSmallestChangesTheAnswer) {
  EXPECT_FALSE(choose(drifting(10.0, 1e-7), toy::problem({}, 5, 1)).converged);
}

TEST(DiscretisationError, IsWhatTheGateSawAndFallsBetween) {
  const TimeStepChoice choice = choose(drifting(1.0, 1e-6), toy::problem({}, 5, 1));
  double at_largest = 0.0;
  for (const TimeStepRow& row : choice.rows) {
    if (row.fraction == 0.4) at_largest = std::max(at_largest, std::abs(row.change));
  }
  EXPECT_DOUBLE_EQ(discretisation_error_at(choice, 0.4), at_largest);
  EXPECT_LT(discretisation_error_at(choice, 0.3), at_largest);
  EXPECT_GT(discretisation_error_at(choice, 0.3), discretisation_error_at(choice, 0.2));
  EXPECT_LT(discretisation_error_at(choice, 0.05), discretisation_error_at(choice, 0.2));
}

// An objective that is lowest at a large step must not draw the gate there.
TEST(ChooseTimeStep, CannotBeDrawnToALargeStepByABetterScoreThere) {
  const Problem problem = toy::problem({.parameters = {0.3, 0.3, 0.7}}, 5, 1);
  const Simulator better_when_coarse = [](const SimulationRequest& request) {
    ParameterSet shifted = request.parameters;
    shifted.friction_particle_particle = 0.3 + (0.4 - request.time_step_fraction);
    return SimulatedRun{.trajectories = toy::run(shifted, 1e-6, request.seed)};
  };
  const TimeStepChoice choice = choose(better_when_coarse, problem);
  EXPECT_LT(choice.fraction, 0.4);
  EXPECT_LT(choice.rows[0].objective, choice.rows[1].objective);  // it was indeed better there
}

TEST(ChooseTimeStep, PassesOverAFractionAtWhichRunsFail) {
  const Simulator fails_when_coarse = [](const SimulationRequest& request) {
    SimulatedRun run{.trajectories = toy::run(request.parameters, 0.002, request.seed)};
    if (request.time_step_fraction > 0.3) run.status = RunStatus::unstable;
    return run;
  };
  EXPECT_DOUBLE_EQ(choose(fails_when_coarse, toy::problem({}, 5, 1)).fraction, 0.2);
}

}  // namespace
}  // namespace graintruth::calibrate
