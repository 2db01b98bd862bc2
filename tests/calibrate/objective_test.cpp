// What is minimised of tracks: the loss, half widths, and what a model that saw nothing gets.
#include "calibrate/compare/objective.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/compare/agreement.h"
#include "calibrate/compare/repeated_rule.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

const RepeatedRule& rule_of(const Problem& problem) {
  return static_cast<const RepeatedRule&>(*problem.all->rule_of("tracks"));
}

// A run that is the replicates' mean, moved by x.
SimulatedRun shifted(const Problem& problem, double x) {
  Channel channel{.values = rule_of(problem).target(0).mean};
  for (std::size_t i = 0; i < channel.values.size(); i += 3) channel.values[i] += x;
  return {.channels = {channel}};
}

double objective(const Problem& problem, const SimulatedRun& run) {
  return problem.all->objective({&run, 1});
}

TEST(Objective, IsZeroAtTheReplicatesMeanAndGrowsAwayFromIt) {
  const Problem problem = toy::problem({}, 5, 1);
  EXPECT_NEAR(objective(problem, shifted(problem, 0.0)), 0.0, 1e-12);
  double last = 0.0;
  for (const double shift : {1e-4, 1e-3, 1e-2, 1e-1}) {
    const double value = objective(problem, shifted(problem, shift));
    EXPECT_GT(value, last);
    last = value;
  }
}

TEST(Objective, GrowsLinearlyFarOut) {
  const Problem problem = toy::problem({}, 5, 1);
  const double once = objective(problem, shifted(problem, 10.0));
  const double twice = objective(problem, shifted(problem, 20.0));
  EXPECT_NEAR(twice / once, 2.0, 1e-3);
}

TEST(Objective, IsFiniteForAModelThatSawNothing) {
  const Problem problem = toy::problem({}, 5, 1);
  const SimulatedRun failed{.status = RunStatus::unstable};
  EXPECT_TRUE(std::isfinite(objective(problem, failed)));
  EXPECT_GT(objective(problem, failed), 1.0);
}

// Eq 4.3: what is minimised is exactly what the report scores.
TEST(Objective, InTheRequestedFormIsOneMinusTheAgreement) {
  const Problem problem = toy::problem({}, 5, 1);
  const auto requested = problem.all->with_form(datasets::ObjectiveForm::requested);
  EXPECT_EQ(requested->form(), datasets::ObjectiveForm::requested);
  for (const ParameterSet& parameters :
       {toy::parameters(0.2, 0.3, 0.7), toy::parameters(0.4, 0.1, 0.7)}) {
    const SimulatedRun run = toy::compared(problem, toy::run(parameters, 0.01, 3));
    const RepeatedRule& rule = rule_of(problem);
    const double percent =
        agreement(rule.target(0).spreads, rule.shape(), run.channels[0].values, Critical::student_t)
            .percent;
    EXPECT_GT(percent, 0.0);
    EXPECT_LT(percent, 100.0);
    EXPECT_NEAR(requested->objective({&run, 1}), 1.0 - percent / 100.0, 1e-12);
  }
  const auto smooth = requested->with_form(datasets::ObjectiveForm::smooth);
  const SimulatedRun run =
      toy::compared(problem, toy::run(toy::parameters(0.2, 0.3, 0.7), 0.01, 3));
  EXPECT_EQ(smooth->objective({&run, 1}), objective(problem, run));
}

TEST(SmoothHalfWidths, NeverFallBelowTheMeasurementsError) {
  datasets::Trajectories track = toy::run(toy::parameters(0.2, 0.3, 0.7), 0.0, 1);
  track.sigmas.assign(track.poses.size(), {1e-3, 2e-3, 3e-3});
  track.scores.assign(track.poses.size(), 1.0);
  const std::vector<datasets::Recording> alike(5, datasets::Recording{.tracks = track});
  const Problem problem = make_problem(toy::experiment(5), alike);
  const std::vector<double>& widths = rule_of(problem).target(0).half_widths;
  for (std::size_t i = 0; i < widths.size(); i += 3) {
    EXPECT_NEAR(widths[i], 1e-3, 1e-12);
    EXPECT_NEAR(widths[i + 2], 3e-3, 1e-12);
  }
}

}  // namespace
}  // namespace graintruth::calibrate
