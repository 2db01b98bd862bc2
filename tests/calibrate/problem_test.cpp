#include "calibrate/problem.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "datasets/store/input_error.h"
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
  const datasets::Trajectories first = resting_film(0.010, 1e-4),
                               second = resting_film(0.012, 1e-4);
  const StartPoses starts = measure_starts(std::array{&first, &second});
  EXPECT_NEAR(starts.mean[0].x, 0.011, 2e-5);
  EXPECT_NEAR(starts.mean[0].z, 0.0, 1e-12);
  EXPECT_NEAR(starts.standard_deviation.x, 0.002 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(starts.standard_deviation.angle, 0.0, 1e-9);
}

TEST(MakeProblem, RefusesTracksThatDoNotFit) {
  const std::vector<datasets::Recording> recordings = toy::recordings({}, 3, 1);
  datasets::Experiment experiment = toy::experiment(3);
  EXPECT_NO_THROW(make_problem(experiment, recordings));
  experiment.particle.count = 5;
  EXPECT_THROW(make_problem(experiment, recordings), datasets::InputError);
  experiment = toy::experiment(3);
  experiment.measurement.frames = 100;
  EXPECT_THROW(make_problem(experiment, recordings), datasets::InputError);
}

std::map<std::string, std::string> parts_of(const datasets::Experiment& experiment,
                                            const std::vector<datasets::Recording>& recordings) {
  const Problem problem = make_problem(experiment, recordings);
  return {problem.parts.begin(), problem.parts.end()};
}

TEST(MakeProblem, ItsPartsSayWhatIsAnother) {
  const std::vector<datasets::Recording> recordings = toy::recordings({}, 3, 1);
  const auto parts = parts_of(toy::experiment(3), recordings);
  EXPECT_EQ(parts_of(toy::experiment(3), recordings), parts);
  const auto changed = [&](const std::map<std::string, std::string>& other) {
    std::vector<std::string> names;
    for (const auto& [name, hash] : parts) {
      if (other.at(name) != hash) names.push_back(name);
    }
    return names;
  };
  datasets::Experiment heavier = toy::experiment(3);
  heavier.particle.model.mass = 0.01 * (1.0 + 1e-7);
  EXPECT_EQ(changed(parts_of(heavier, recordings)), std::vector<std::string>{"particle"});
  // Seen after the event alone, so that nobody starts elsewhere
  std::vector<datasets::Recording> moved = recordings;
  moved[1].tracks->poses[7].x += 1e-12;
  EXPECT_EQ(changed(parts_of(toy::experiment(3), moved)),
            std::vector<std::string>{"recordings or [measure]"});
  // What is known besides the data changes no simulation
  datasets::Experiment with_prior = toy::experiment(3);
  with_prior.tuned[0].prior = {0.3, 0.02};
  EXPECT_EQ(changed(parts_of(with_prior, recordings)), std::vector<std::string>{});
}

}  // namespace
}  // namespace graintruth::calibrate
