// What replicates and seeds say of the difference between two models.
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/compare/channel_comparison.h"
#include "calibrate/ensemble.h"
#include "calibrate/knowledge/uncertainty.h"
#include "calibrate/result/results.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double noise = 0.001;  // m
constexpr int seeds = 6;

Evaluation at(const Problem& problem, const ParameterSet& parameters, std::uint64_t first_seed) {
  Evaluation evaluation{.parameters = parameters};
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    evaluation.runs.push_back(
        toy::compared(problem, toy::run(parameters, noise, first_seed + seed)));
  }
  evaluation.objective = problem.all->objective(evaluation.runs);
  return evaluation;
}

// The lowest J along friction between particles, which is convex near the truth of the toy.
Evaluation lowest(const Problem& problem, const ParameterSet& truth, std::uint64_t first_seed) {
  const auto with = [&](double friction) {
    ParameterSet parameters = truth;
    parameters.set("friction_particle_particle", friction);
    return at(problem, parameters, first_seed);
  };
  double lower = truth.of("friction_particle_particle") - 0.03;
  double upper = truth.of("friction_particle_particle") + 0.03;
  while (upper - lower > 1e-5) {
    const double third = (upper - lower) / 3.0;
    if (with(lower + third).objective < with(upper - third).objective) {
      upper -= third;
    } else {
      lower += third;
    }
  }
  return with(0.5 * (lower + upper));
}

// Replicates whose half widths come from themselves seem to agree better than they do: were that
// not accounted for, 85 of 100 would be held here. Of 400 repeats of a test that holds 95 %, 95 %
// lie between 371 and 388.
TEST(ChannelComparison, TheTruthIsAllowedAsOftenAsAsked) {
  constexpr int repeats = 400;
  int held = 0;
  for (std::uint64_t repeat = 0; repeat < repeats; ++repeat) {
    const toy::Truth truth{.noise = noise};
    const Problem problem = toy::problem(truth, 5, 5000 + repeat);
    const std::uint64_t first_seed = 1'000'000 + 100 * repeat;
    const Evaluation best = lowest(problem, truth.parameters, first_seed);
    const Evaluation at_truth = at(problem, truth.parameters, first_seed);
    const PooledChance chance = pool_chance(*problem.all, std::vector{best, at_truth}, 0.0);
    held += excess_over(*problem.all, best, at_truth, chance, {}).is_compatible();
  }
  EXPECT_GE(held, 0.92 * repeats);
  EXPECT_LE(held, 0.98 * repeats);
}

TEST(ChannelComparison, TwoReplicatesTellADifferenceToo) {
  const Problem problem = toy::problem({.noise = noise}, 2, 1);
  const Evaluation best = at(problem, toy::parameters(0.2, 0.3, 0.7), 10);
  const Evaluation other = at(problem, toy::parameters(0.25, 0.3, 0.7), 10);
  const double half_width = problem.all->half_width_of_difference(best, other, {});
  EXPECT_GT(half_width, 0.0);
  EXPECT_TRUE(std::isfinite(half_width));
}

// Where most runs failed the objective is that of rest, whatever the replicates are.
TEST(ChannelComparison, FailedRunsAreComparedToo) {
  const Problem problem = toy::problem({.noise = noise}, 5, 1);
  const Evaluation best = at(problem, toy::parameters(0.2, 0.3, 0.7), 10);
  Evaluation failed = best;
  for (SimulatedRun& run : failed.runs) run.status = RunStatus::unstable;
  failed.objective = problem.all->objective(failed.runs);
  const double allowed = problem.all->allowed_excess(best, failed, {});
  EXPECT_TRUE(std::isfinite(allowed));
  EXPECT_GT(failed.objective - best.objective, allowed);
}

TEST(Observables, OneAloneTellsTheAgreement) {
  datasets::Experiment experiment = toy::experiment(5);
  experiment.measurement.observables = {{.name = "heap_height"}, {.name = "tracks"}};
  EXPECT_EQ(Observables(experiment).of_agreement()->name(), "heap_height");
  experiment.measurement.observables = {{.name = "tracks"}, {.name = "heap_height"}};
  EXPECT_EQ(Observables(experiment).of_agreement()->name(), "tracks");
  // What it tells is not overwritten by the other
  const auto told = [&] {
    const Problem problem = make_problem(experiment, toy::recordings({}, 5, 1));
    Evaluation evaluation;
    for (const datasets::Recording& recording : toy::recordings({}, 3, 2))
      evaluation.runs.push_back({.channels = problem.observables->measure(
                                     recording, problem.situations[0], &problem.measured[0])});
    Results results;
    for (const auto& observable : problem.observables->all()) {
      if (problem.all->rule_of(observable->name()) != nullptr)
        observable->tell_evaluation(problem, evaluation, results);
    }
    return results.json.at("agreement_percent").get<double>();
  };
  const double of_both = told();
  experiment.measurement.observables = {{.name = "tracks"}};
  EXPECT_EQ(of_both, told());
}

}  // namespace
}  // namespace graintruth::calibrate
