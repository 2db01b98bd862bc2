// A slice of a long drum, one and two periods deep: the same grains at the same slope.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/observables/steady_surface.h"
#include "calibrate/problem.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr int seeds = 4, grains_a_period = 110;
constexpr double period = 16.0;  // mm; four grains

std::string experiment_of(int periods, bool has_panes) {
  return fmt::format(R"(title = "A drum"
[particle]
count = {}
mass_g = 0.0831
radius_mm = 2
[material]
elastic_modulus_gpa = 63
poisson_ratio = 0.25
friction_particle_particle = 0.46
friction_particle_wall = 0.46
friction_particle_shell = 0.7
restitution = 0.6
rolling_friction_particle_particle = 0.1
rolling_friction_particle_wall = 0.1
[rig]
kind = "rotating_drum"
drum_diameter_mm = 48
drum_depth_mm = {}
turning_rpm = 15
periodic_depth = {}
[measure]
observables = ["drum_surface"]
frame_interval_s = 0.02
frames = 101
[[replicate]]
outline = "one.csv"
[[replicate]]
outline = "two.csv"
)",
                     periods * grains_a_period,
                     periods * period,
                     !has_panes);
}

// Degrees, of every seed.
std::vector<double> slopes_of(int periods, bool has_panes) {
  const tests::TemporaryFolder folder;
  for (const char* name : {"one.csv", "two.csv"}) folder.write(name, "time_s,column_m,height_m\n");
  const datasets::Experiment experiment =
      datasets::load_experiment(folder.write("experiment.toml", experiment_of(periods, has_panes)));
  const std::vector<datasets::Recording> recordings(experiment.replicates.size());
  const Problem problem = plan_problem(experiment, recordings);
  const Situation situation{.particle = experiment.particle,
                            .rig = experiment.replicates.front().rig,
                            .measurement = experiment.measurement};
  std::vector<double> slopes;
  for (int seed = 1; seed <= seeds; ++seed) {
    const EngineRun run = problem.engine->run(
        problem.spec_of(0, datasets::bench_parameters(experiment), 0.5, seed), {});
    EXPECT_EQ(run.status, RunStatus::completed) << run.message;
    const auto surface = steady_surface(run.recording.outlines.front(), situation);
    if (!surface) continue;
    slopes.push_back(-std::atan(surface->slope) * 180.0 / std::numbers::pi);
    fmt::print("{} x {} mm{}: {:.2f} degrees, {:.1f} s\n",
               periods,
               period,
               has_panes ? " between panes" : "",
               slopes.back(),
               run.seconds);
    std::fflush(stdout);
  }
  return slopes;
}

struct Mean {
  double value = 0.0, error = 0.0;  // degrees; standard error
};
Mean mean_of(const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  Mean mean;
  for (const double value : values) mean.value += value / count;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean.value) * (value - mean.value);
  mean.error = std::sqrt(squares / (count - 1.0) / count);
  return mean;
}

// Equal slopes differ by more than this one time in a hundred.
TEST(DrumSlice, IsAsSteepOnePeriodDeepAsTwo) {
  const Mean one = mean_of(slopes_of(1, false)), two = mean_of(slopes_of(2, false));
  const double error = std::hypot(one.error, two.error);
  EXPECT_NEAR(one.value, two.value, student_t_quantile(0.995, 2.0 * (seeds - 1.0)) * error);
  EXPECT_LT(error, 1.5);  // so that it can fail: panes make it steeper by more
  const Mean panes = mean_of(slopes_of(1, true));
  EXPECT_GT(panes.value, std::max(one.value, two.value) + 2.0 * std::hypot(error, panes.error));
}

}  // namespace
}  // namespace graintruth::calibrate
