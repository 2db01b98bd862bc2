#include "calibrate/search/time_step_gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calibrate/closed_bin.h"
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

constexpr std::size_t first_seeds = 8, most_seeds = 32;

TimeStepChoice choose(const Engine& engine, Problem problem) {
  Journal journal(":memory:");
  const auto executor = make_executor("threads", 2);
  const std::vector<ParameterSet> places = {toy::parameters(0.3, 0.3, 0.7),
                                            toy::parameters(0.1, 0.4, 0.7)};
  return choose_time_step(*toy::ensemble(problem, engine, journal, *executor),
                          places,
                          0.4,
                          make_seeds(1, "gate", most_seeds),
                          first_seeds);
}

TEST(ChooseTimeStep, TakesTheLargestWhereTheStepDoesNotMatter) {
  const TimeStepChoice choice = choose(drifting(0.0, 0.002), toy::problem({}, 5, 1));
  EXPECT_EQ(choice.verdict, StepVerdict::resolved);
  EXPECT_DOUBLE_EQ(choice.fraction, 0.4);
  for (const TimeStepRow& row : choice.rows) EXPECT_EQ(row.seeds, first_seeds);
  EXPECT_EQ(choice.rows.size(), 4U);  // two places, the step and its half
}

TEST(ChooseTimeStep, TakesASmallerOneWhereItDoes) {
  const TimeStepChoice choice = choose(drifting(1.0, 1e-6), toy::problem({}, 5, 1));
  EXPECT_LT(choice.fraction, 0.4);
  EXPECT_GT(choice.discretisation_error, 0.0);
}

TEST(ChooseTimeStep, SaysWhenEvenTheSmallestChangesTheAnswer) {
  const TimeStepChoice choice = choose(drifting(10.0, 1e-7), toy::problem({}, 5, 1));
  EXPECT_EQ(choice.verdict, StepVerdict::changes);
  EXPECT_DOUBLE_EQ(choice.fraction, 0.1);
}

// A change that can be told from chance is no harm where replicates know a hundred times less.
TEST(ChooseTimeStep, KeepsAStepWhoseChangeIsSeenButLittle) {
  const TimeStepChoice choice = choose(drifting(0.002, 1e-6), toy::problem({}, 5, 1));
  EXPECT_EQ(choice.verdict, StepVerdict::resolved);
  EXPECT_DOUBLE_EQ(choice.fraction, 0.4);
  ASSERT_TRUE(choice.rows.front().change.has_value());
  EXPECT_GT(std::abs(choice.rows.front().change->change),
            choice.rows.front().change->noise.half_width);
}

// Every run scatters on its own, whatever its seed did at another step.
toy::ClosedEngine scattering(double noise) {
  return toy::ClosedEngine([noise](const SimulationSpec& spec) {
    const auto step = static_cast<std::uint64_t>(1e6 * spec.time_step_fraction);
    return toy::as_run(toy::run(spec.parameters, noise, spec.seed + step));
  });
}

// Runs that scatter fifty times as widely as replicates say nothing of the step.
TEST(ChooseTimeStep, IsNotPassedByRunsThatScatterWildly) {
  const TimeStepChoice choice = choose(scattering(0.1), toy::problem({}, 5, 1));
  EXPECT_EQ(choice.verdict, StepVerdict::not_resolved);
  EXPECT_DOUBLE_EQ(choice.fraction, 0.4);  // a smaller one would tell no more
  // More seeds cannot be enough, and are not spent
  for (const TimeStepRow& row : choice.rows) EXPECT_EQ(row.seeds, static_cast<int>(first_seeds));
}

TEST(ChooseTimeStep, SpendsMoreSeedsWhereTheyAreEnough) {
  const TimeStepChoice choice = choose(scattering(0.0015), toy::problem({}, 5, 1));
  EXPECT_EQ(choice.verdict, StepVerdict::resolved);
  EXPECT_GT(choice.rows.front().seeds, static_cast<int>(first_seeds));
  EXPECT_LE(choice.rows.front().seeds, static_cast<int>(most_seeds));
}

// A bin whose runs scatter wildly: of each replicate one simulation, judged by the scatter of the
// films, never by its own.
TEST(ChooseTimeStep, IsNotPassedByABinThatScattersWildly) {
  const auto verdict_of = [](double noise) {
    Problem problem = closed_bin::problem(closed_bin::parameters(0.3, 0.3, 0.7), 0.02, 5);
    const tests::ClosedEngine scattering([=](const SimulationSpec& spec) {
      SimulationSpec other = spec;
      other.seed += static_cast<std::uint64_t>(1e6 * spec.time_step_fraction);
      return closed_bin::engine(noise).run(other, {});
    });
    Journal journal(":memory:");
    const auto executor = make_executor("threads", 2);
    const std::vector<ParameterSet> places = {closed_bin::parameters(0.35, 0.35, 0.7)};
    return choose_time_step(*toy::ensemble(problem, scattering, journal, *executor),
                            places,
                            0.05,
                            make_seeds(1, "gate", 4),
                            1)
        .verdict;
  };
  EXPECT_EQ(verdict_of(0.3), StepVerdict::not_resolved);
  EXPECT_EQ(verdict_of(0.001), StepVerdict::resolved);
}

TEST(DiscretisationError, IsWhatTheGateSawAndFallsBetween) {
  const TimeStepChoice choice = choose(drifting(1.0, 1e-6), toy::problem({}, 5, 1));
  double at_largest = 0.0;
  for (const TimeStepRow& row : choice.rows) {
    if (row.fraction == 0.4) at_largest = std::max(at_largest, std::abs(row.change->change));
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
