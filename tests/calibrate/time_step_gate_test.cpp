#include "calibrate/search/time_step_gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

// The toy's tracks move with 0.2 fraction^2; `gain` makes that larger.
toy::ClosedEngine drifting(double gain, double noise) {
  return toy::ClosedEngine([=](const SimulationSpec& spec) {
    ParameterSet shifted = spec.parameters;
    shifted.set("friction_particle_particle",
                shifted.of("friction_particle_particle") +
                    gain * spec.time_step_fraction * spec.time_step_fraction);
    EngineRun run = toy::as_run(toy::run(shifted, noise, spec.seed));
    run.time_step = spec.time_step_fraction;
    return run;
  });
}

TimeStepChoice choose(const Engine& engine, Problem problem) {
  Journal journal(":memory:");
  const auto executor = make_executor("threads", 2);
  const std::vector<ParameterSet> places = {toy::parameters(0.3, 0.3, 0.7),
                                            toy::parameters(0.1, 0.4, 0.7)};
  return choose_time_step(
      *toy::ensemble(problem, engine, journal, *executor), places, 0.4, make_seeds(1, "gate", 8));
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
  const Problem problem = toy::problem({.parameters = toy::parameters(0.3, 0.3, 0.7)}, 5, 1);
  const toy::ClosedEngine better_when_coarse([](const SimulationSpec& spec) {
    ParameterSet shifted = spec.parameters;
    shifted.set("friction_particle_particle", 0.3 + (0.4 - spec.time_step_fraction));
    return toy::as_run(toy::run(shifted, 1e-6, spec.seed));
  });
  const TimeStepChoice choice = choose(better_when_coarse, problem);
  EXPECT_LT(choice.fraction, 0.4);
  EXPECT_LT(choice.rows[0].objective, choice.rows[1].objective);  // it was indeed better there
}

TEST(ChooseTimeStep, PassesOverAFractionAtWhichRunsFail) {
  const toy::ClosedEngine fails_when_coarse([](const SimulationSpec& spec) {
    EngineRun run = toy::as_run(toy::run(spec.parameters, 0.002, spec.seed));
    if (spec.time_step_fraction > 0.3) run.status = RunStatus::unstable;
    return run;
  });
  EXPECT_DOUBLE_EQ(choose(fails_when_coarse, toy::problem({}, 5, 1)).fraction, 0.2);
}

}  // namespace
}  // namespace graintruth::calibrate
