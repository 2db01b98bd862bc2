#include "calibrate/problem.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/input_error.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

// A film of one particle that rests until time 0 and then sinks; `jitter` alternates between
// frames.
datasets::Trajectories resting_film(double x, double jitter) {
  datasets::Trajectories film = datasets::make_trajectories(30, 1, false);
  for (std::size_t frame = 0; frame < 30; ++frame) {
    film.time[frame] = 0.02 * (static_cast<double>(frame) - 10.0);
    const double noise = frame % 2 == 0 ? jitter : -jitter;
    film.poses[frame] = {x + noise, std::min(0.0, -0.05 * film.time[frame]), 0.3};
  }
  return film;
}

TEST(MeasureStarts, AveragesTheStillFramesAndPoolsTheSpread) {
  const std::vector<datasets::Trajectories> films = {resting_film(0.010, 1e-4),
                                                     resting_film(0.012, 1e-4)};
  const StartPoses starts = measure_starts(films);
  EXPECT_NEAR(starts.mean[0].x, 0.011, 2e-5);
  EXPECT_NEAR(starts.mean[0].z, 0.0, 1e-12);
  EXPECT_NEAR(starts.standard_deviation.x, 0.002 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(starts.standard_deviation.angle, 0.0, 1e-9);
}

TEST(MakeProblem, RefusesTracksThatDoNotFit) {
  const Problem good = toy::problem({}, 3, 1);
  datasets::Experiment experiment = good.experiment;
  experiment.particle.count = 5;
  EXPECT_THROW(make_problem(experiment, good.comparison->replicates()), datasets::InputError);
  experiment = good.experiment;
  experiment.measurement.frames = 100;
  EXPECT_THROW(make_problem(experiment, good.comparison->replicates()), datasets::InputError);
}

TEST(MakeProblem, ItsHashKnowsEveryInput) {
  const Problem problem = toy::problem({}, 3, 1);
  EXPECT_EQ(make_problem(problem.experiment, problem.comparison->replicates()).hash, problem.hash);
  datasets::Experiment heavier = problem.experiment;
  heavier.particle.mass *= 1.0000001;
  EXPECT_NE(make_problem(heavier, problem.comparison->replicates()).hash, problem.hash);
  std::vector<datasets::Trajectories> moved = problem.comparison->replicates();
  moved[1].poses[7].x += 1e-12;
  EXPECT_NE(make_problem(problem.experiment, moved).hash, problem.hash);
}

}  // namespace
}  // namespace graintruth::calibrate
