#include "calibrate/dem_simulator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/measure.h"

namespace graintruth::calibrate {
namespace {

// The bundled rig with a soft modulus, so that a test may run it, for half a second of piston
// motion.
datasets::Experiment soft_rig() {
  datasets::Experiment experiment =
      datasets::load_experiment(GRAINTRUTH_SOURCE_DIR "/datasets/micro/experiment.toml");
  experiment.material.elastic_modulus = 5e7;
  experiment.measurement = {.frame_interval = 0.1, .frames = 6};
  return experiment;
}

StartPoses nominal_starts(const datasets::Experiment& experiment) {
  StartPoses starts;
  for (const datasets::StartPlace& place : experiment.starts)
    starts.mean.push_back({place.x, place.z, place.angle});
  starts.standard_deviation = {3e-4, 3e-4, 0.01};
  return starts;
}

TEST(DemSimulator, BringsAParticleDownWithThePiston) {
  datasets::Experiment experiment = soft_rig();
  experiment.particle.count = 1;
  experiment.starts = {{0.0, 0.0222, 0.0}};  // flat, in the middle of the column
  const Simulator simulator = make_dem_simulator(experiment, nominal_starts(experiment), {});
  const SimulatedRun run =
      simulator({{0.12, 0.17, 0.82}, largest_time_step_fraction(experiment), 1});
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  // Set in motion at once, the piston leaves the particle behind by 46 mm/s for v/g = 4.7 ms: 0.1
  // mm at most.
  for (std::size_t frame = 0; frame < run.trajectories.frames(); ++frame) {
    const double sunk = run.trajectories.poses[0].z - run.trajectories.poses[frame].z;
    EXPECT_NEAR(sunk, 0.046 * run.trajectories.time[frame], 2e-4);
  }
}

TEST(DemSimulator, IsTheSameForTheSameRequestAndOtherwiseForAnotherSeed) {
  const datasets::Experiment experiment = soft_rig();
  const Simulator simulator = make_dem_simulator(experiment, nominal_starts(experiment), {});
  const SimulationRequest request{{0.12, 0.17, 0.82}, largest_time_step_fraction(experiment), 1};
  const SimulatedRun once = simulator(request);
  const SimulatedRun again = simulator(request);
  SimulationRequest other = request;
  other.seed = 2;
  const SimulatedRun different = simulator(other);
  for (std::size_t i = 0; i < once.trajectories.poses.size(); ++i) {
    EXPECT_EQ(once.trajectories.poses[i].x, again.trajectories.poses[i].x);
    EXPECT_EQ(once.trajectories.poses[i].angle, again.trajectories.poses[i].angle);
  }
  EXPECT_NE(once.trajectories.poses.back().x, different.trajectories.poses.back().x);
}

TEST(DemSimulator, StartsWhereTheFilmsSay) {
  const datasets::Experiment experiment = soft_rig();
  StartPoses starts = nominal_starts(experiment);
  starts.standard_deviation = {0.0, 0.0, 0.0};
  const SimulatedRun run = make_dem_simulator(
      experiment, starts, {})({{0.12, 0.17, 0.82}, largest_time_step_fraction(experiment), 1});
  ASSERT_EQ(run.status, RunStatus::completed);
  for (std::size_t particle = 0; particle < starts.mean.size(); ++particle) {
    const datasets::Pose& pose = run.trajectories.poses[particle];
    // Nominal places overlap by a few tenths of a millimetre, because real particles differ and the
    // filmed ones were soft.
    EXPECT_NEAR(pose.x, starts.mean[particle].x, 1e-3);
    EXPECT_NEAR(pose.z, starts.mean[particle].z, 1e-3);
    EXPECT_NEAR(difference(Quantity::angle, pose.angle, starts.mean[particle].angle), 0.0, 0.03);
  }
}

TEST(DemSimulator, StopsWhenAsked) {
  const datasets::Experiment experiment = soft_rig();
  const Simulator simulator =
      make_dem_simulator(experiment, nominal_starts(experiment), {.stop = [] { return true; }});
  EXPECT_THROW(simulator({{0.1, 0.1, 0.8}, largest_time_step_fraction(experiment), 1}),
               Interrupted);
}

TEST(DemSimulator, TakesLongerThanAllowedIsAStatus) {
  const datasets::Experiment experiment = soft_rig();
  const Simulator simulator =
      make_dem_simulator(experiment, nominal_starts(experiment), {.time_limit = 0.0});
  const SimulatedRun run = simulator({{0.1, 0.1, 0.8}, largest_time_step_fraction(experiment), 1});
  EXPECT_EQ(run.status, RunStatus::timed_out);
}

TEST(LargestTimeStepFraction, IsBelowTheRayleighStep) {
  const datasets::Experiment experiment = soft_rig();
  EXPECT_GT(largest_time_step_fraction(experiment), 0.01);
  EXPECT_LE(largest_time_step_fraction(experiment), 1.0);
}

}  // namespace
}  // namespace graintruth::calibrate
