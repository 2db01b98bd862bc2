#include "calibrate/objective.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/agreement.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

datasets::Trajectories shifted(datasets::Trajectories tracks, double x) {
  for (datasets::Pose& pose : tracks.poses) pose.x += x;
  return tracks;
}

TEST(Objective, IsZeroAtTheReplicatesMeanAndGrowsAwayFromIt) {
  const Problem problem = toy::problem({}, 5, 1);
  const auto [replicates, mean, widths] = problem.comparison->target();
  EXPECT_NEAR(objective(mean, widths, mean), 0.0, 1e-12);
  double last = 0.0;
  for (const double shift : {1e-4, 1e-3, 1e-2, 1e-1}) {
    const double value = objective(mean, widths, shifted(mean, shift));
    EXPECT_GT(value, last);
    last = value;
  }
}

TEST(Objective, GrowsLinearlyFarOut) {
  const Problem problem = toy::problem({}, 5, 1);
  const auto [replicates, mean, widths] = problem.comparison->target();
  const double once = objective(mean, widths, shifted(mean, 10.0));
  const double twice = objective(mean, widths, shifted(mean, 20.0));
  EXPECT_NEAR(twice / once, 2.0, 1e-3);
}

TEST(Objective, IsFiniteForAModelThatSawNothing) {
  const Problem problem = toy::problem({}, 5, 1);
  const auto [replicates, mean, widths] = problem.comparison->target();
  const double rest = objective_of_rest(mean, widths);
  EXPECT_TRUE(std::isfinite(rest));
  EXPECT_GT(rest, 1.0);
}

// Eq 4.3: what is minimised is exactly what the report scores.
TEST(Objective, InTheRequestedFormIsOneMinusTheAgreement) {
  const Problem problem = toy::problem({}, 5, 1);
  const auto requested = problem.comparison->with_form(datasets::ObjectiveForm::requested);
  EXPECT_EQ(requested->form(), datasets::ObjectiveForm::requested);
  for (const ParameterSet& parameters :
       {ParameterSet{0.2, 0.3, 0.7}, ParameterSet{0.4, 0.1, 0.7}}) {
    const SimulatedRun run{.trajectories = toy::run(parameters, 0.01, 3)};
    const double percent =
        agreement(problem.comparison->target().replicates, run.trajectories, Critical::student_t)
            .percent;
    EXPECT_GT(percent, 0.0);
    EXPECT_LT(percent, 100.0);
    EXPECT_NEAR(requested->objective({&run, 1}), 1.0 - percent / 100.0, 1e-12);
  }
  const auto smooth = requested->with_form(datasets::ObjectiveForm::smooth);
  const SimulatedRun run{.trajectories = toy::run({0.2, 0.3, 0.7}, 0.01, 3)};
  EXPECT_EQ(smooth->objective({&run, 1}), problem.comparison->objective({&run, 1}));
}

TEST(SmoothHalfWidths, NeverFallBelowTheMeasurementsError) {
  std::vector<datasets::Trajectories> alike(5, toy::run({0.2, 0.3, 0.7}, 0.0, 1));
  for (datasets::Trajectories& track : alike)
    track.sigmas.assign(track.poses.size(), {1e-3, 2e-3, 3e-3});
  const HalfWidths widths = smooth_half_widths(measure(alike), alike);
  for (const auto& width : widths.half_width) {
    EXPECT_NEAR(width[0], 1e-3, 1e-12);
    EXPECT_NEAR(width[2], 3e-3, 1e-12);
  }
}

}  // namespace
}  // namespace graintruth::calibrate
