// What replicates and seeds say of the difference between two models.
#include "calibrate/track_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/ensemble.h"
#include "calibrate/uncertainty.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double noise = 0.001;  // m
constexpr int seeds = 6;

Evaluation at(const TrackComparison& comparison,
              const ParameterSet& parameters,
              std::uint64_t first_seed) {
  Evaluation evaluation{.parameters = parameters};
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    evaluation.runs.push_back({.trajectories = toy::run(parameters, noise, first_seed + seed)});
  evaluation.objective = comparison.objective(evaluation.runs);
  return evaluation;
}

// The lowest J along friction between particles, which is convex near the truth of the toy.
Evaluation lowest(const TrackComparison& comparison,
                  const ParameterSet& truth,
                  std::uint64_t first_seed) {
  const auto with = [&](double friction) {
    ParameterSet parameters = truth;
    parameters.friction_particle_particle = friction;
    return at(comparison, parameters, first_seed);
  };
  double lower = truth.friction_particle_particle - 0.03;
  double upper = truth.friction_particle_particle + 0.03;
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
TEST(TrackComparison, TheTruthIsAllowedAsOftenAsAsked) {
  constexpr int repeats = 400;
  int held = 0;
  for (std::uint64_t repeat = 0; repeat < repeats; ++repeat) {
    const toy::Truth truth{.noise = noise};
    const auto comparison = toy::problem(truth, 5, 5000 + repeat).comparison;
    const std::uint64_t first_seed = 1'000'000 + 100 * repeat;
    const Evaluation best = lowest(*comparison, truth.parameters, first_seed);
    const Evaluation at_truth = at(*comparison, truth.parameters, first_seed);
    const PooledChance chance = pool_chance(*comparison, std::vector{best, at_truth}, 0.0);
    held += excess_over(*comparison, best, at_truth, chance, {}).is_compatible();
  }
  EXPECT_GE(held, 0.92 * repeats);
  EXPECT_LE(held, 0.98 * repeats);
}

TEST(TrackComparison, TwoReplicatesTellADifferenceToo) {
  const auto comparison = toy::problem({.noise = noise}, 2, 1).comparison;
  const Evaluation best = at(*comparison, {0.2, 0.3, 0.7}, 10);
  const Evaluation other = at(*comparison, {0.25, 0.3, 0.7}, 10);
  const double half_width = comparison->half_width_of_difference(best, other, {}, {});
  EXPECT_GT(half_width, 0.0);
  EXPECT_TRUE(std::isfinite(half_width));
}

// Where most runs failed the objective is that of rest, whatever the replicates are.
TEST(TrackComparison, FailedRunsAreComparedToo) {
  const auto comparison = toy::problem({.noise = noise}, 5, 1).comparison;
  const Evaluation best = at(*comparison, {0.2, 0.3, 0.7}, 10);
  Evaluation failed = best;
  for (SimulatedRun& run : failed.runs) run.status = RunStatus::unstable;
  failed.objective = comparison->objective(failed.runs);
  const double allowed = comparison->allowed_excess(best, failed, {}, {});
  EXPECT_TRUE(std::isfinite(allowed));
  EXPECT_GT(failed.objective - best.objective, allowed);
}

}  // namespace
}  // namespace graintruth::calibrate
