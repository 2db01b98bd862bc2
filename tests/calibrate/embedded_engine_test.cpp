// The embedded simulator behind the engine's door: grains that a piston lets down.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/engines/embedded.h"
#include "calibrate/problem.h"
#include "datasets/store/input_error.h"
#include "sim/laws/time_step.h"
#include "tests/support/parameters.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::parameters;

const ParameterSet usual = parameters(0.12, 0.17, 0.82);

// The bundled rig with a soft modulus, so that a test may run it, for half a second of piston
// motion.
datasets::Experiment soft_rig() {
  datasets::Experiment experiment =
      datasets::load_experiment(GRAINTRUTH_SOURCE_DIR "/datasets/micro/experiment.toml");
  experiment.material.elastic_modulus = 5e7;
  experiment.measurement.frame_interval = 0.1;
  experiment.measurement.frames = 6;
  experiment.replicates.resize(1);
  return experiment;
}

// From the nominal starting places.
SimulationSpec spec_of(const datasets::Experiment& experiment,
                       const datasets::Pose& placing = {3e-4, 3e-4, 0.01}) {
  datasets::Trajectories starts =
      datasets::make_trajectories(1, static_cast<int>(experiment.starts.size()), false);
  for (std::size_t i = 0; i < experiment.starts.size(); ++i) {
    const datasets::StartPlace& place = experiment.starts[i];
    starts.poses[i] = {place.x, place.z, place.angle};
  }
  const std::vector<datasets::Recording> recordings = {{.tracks = starts}};
  const Problem problem = plan_problem(experiment, recordings);
  SimulationSpec spec = problem.spec_of(0, usual, problem.largest_time_step_fraction(), 1);
  spec.start.standard_deviation = placing;
  return spec;
}

datasets::Trajectories tracks_of(const SimulationSpec& spec) {
  const EngineRun run = embedded_engine().run(spec, {});
  EXPECT_EQ(run.status, RunStatus::completed) << run.message;
  return run.recording.tracks.value_or(datasets::Trajectories{});
}

TEST(EmbeddedEngine, BringsAParticleDownWithThePiston) {
  datasets::Experiment experiment = soft_rig();
  experiment.particle.count = 1;
  experiment.starts = {{0.0, 0.0222, 0.0}};  // flat, in the middle of the column
  const datasets::Trajectories tracks = tracks_of(spec_of(experiment));
  ASSERT_EQ(tracks.frames(), 6U);
  // Set in motion at once, the piston leaves the particle behind by 46 mm/s for v/g = 4.7 ms: 0.1
  // mm at most.
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    EXPECT_NEAR(tracks.poses[0].z - tracks.poses[frame].z, 0.046 * tracks.time[frame], 2e-4);
  }
}

// Only surfaces that lose next to nothing ask for more steps a contact; those of the experiment do
// not, whatever a scene without surfaces would.
TEST(EmbeddedEngine, StepsFinerOnlyForSurfacesThatHardlyLose) {
  SimulationSpec spec = spec_of(soft_rig());
  for (datasets::ScenePhase& phase : spec.scene.phases) phase.fastest_impact = 20.0;
  const auto fraction_at = [&spec](double restitution) {
    for (datasets::SceneSurfaces& surfaces : spec.scene.surfaces)
      surfaces.restitution = restitution;
    return embedded_engine().largest_time_step_fraction(spec);
  };
  const double of_losing = fraction_at(0.75);
  EXPECT_LT(of_losing, 1.0);  // the duration of an impact decides
  EXPECT_EQ(fraction_at(0.5), of_losing);
  EXPECT_NEAR(fraction_at(1.0), of_losing / sim::kStepsWithoutLoss, 1e-12);
}

TEST(EmbeddedEngine, GivesTheSameForTheSameSpecAndOtherwiseForAnotherSeed) {
  SimulationSpec spec = spec_of(soft_rig());
  const datasets::Trajectories once = tracks_of(spec), again = tracks_of(spec);
  spec.seed = 2;
  const datasets::Trajectories different = tracks_of(spec);
  for (std::size_t i = 0; i < once.poses.size(); ++i) {
    EXPECT_EQ(once.poses[i].x, again.poses[i].x);
    EXPECT_EQ(once.poses[i].angle, again.poses[i].angle);
  }
  EXPECT_NE(once.poses.back().x, different.poses.back().x);
}

TEST(EmbeddedEngine, GivesTheSameForASpecThatWasWrittenAndRead) {
  const SimulationSpec spec = spec_of(soft_rig());
  const SimulationSpec read = spec_from_text(to_text(spec));
  EXPECT_EQ(fingerprint_of(read), fingerprint_of(spec));
  const datasets::Trajectories once = tracks_of(spec), again = tracks_of(read);
  ASSERT_EQ(once.poses.size(), again.poses.size());
  for (std::size_t i = 0; i < once.poses.size(); ++i) EXPECT_EQ(once.poses[i].x, again.poses[i].x);
}

TEST(EmbeddedEngine, StartsWhereTheFilmsSay) {
  const datasets::Experiment experiment = soft_rig();
  const datasets::Trajectories tracks = tracks_of(spec_of(experiment, {0.0, 0.0, 0.0}));
  for (std::size_t particle = 0; particle < experiment.starts.size(); ++particle) {
    const datasets::Pose& pose = tracks.poses[particle];
    const datasets::StartPlace& start = experiment.starts[particle];
    // Nominal places overlap by a few tenths of a millimetre, because real particles differ and the
    // filmed ones were soft.
    EXPECT_NEAR(pose.x, start.x, 1e-3);
    EXPECT_NEAR(pose.z, start.z, 1e-3);
    EXPECT_NEAR(difference(Difference::half_turn, pose.angle, start.angle), 0.0, 0.03);
  }
}

TEST(EmbeddedEngine, StopsWhenAsked) {
  EXPECT_THROW(embedded_engine().run(spec_of(soft_rig()), {.stop = [] { return true; }}),
               Interrupted);
}

// By a count of steps and by no clock: the last step that is allowed decides, on any machine.
TEST(EmbeddedEngine, ThatItTakesMoreStepsThanAllowedIsAStatus) {
  const SimulationSpec spec = spec_of(soft_rig());
  std::int64_t enough = 1, few = 1;
  while (embedded_engine().run(spec, {.step_limit = enough}).status == RunStatus::timed_out) {
    few = enough;
    enough *= 2;
  }
  while (enough - few > 1) {
    const std::int64_t middle = (few + enough) / 2;
    const EngineRun run = embedded_engine().run(spec, {.step_limit = middle});
    (run.status == RunStatus::timed_out ? few : enough) = middle;
    if (run.status != RunStatus::timed_out) continue;
    EXPECT_EQ(run.message, fmt::format("it takes more than {} steps", middle));
    EXPECT_FALSE(run.recording.tracks.has_value());
  }
  EXPECT_GT(enough, 100);
  const EngineRun limited = embedded_engine().run(spec, {.step_limit = enough});
  const EngineRun free = embedded_engine().run(spec, {});
  ASSERT_EQ(limited.status, RunStatus::completed);
  ASSERT_EQ(free.status, RunStatus::completed);
  for (std::size_t i = 0; i < free.recording.tracks->poses.size(); ++i)
    EXPECT_EQ(limited.recording.tracks->poses[i].x, free.recording.tracks->poses[i].x);
}

// One ball fills the region from which both should rain: the second one never finds room.
TEST(EmbeddedEngine, RainThatFindsNoRoomEndsByACountOfSteps) {
  const tests::TemporaryFolder folder;
  SimulationSpec spec;
  spec.scene = datasets::load_scene(folder.write("scene.toml", R"(
title = "Two balls where one has room"
dimensions = 3
[[material]]
name = "ball"
elastic_modulus_mpa = 20
poisson_ratio = 0.3
[[material]]
name = "wall"
rigid = true
[[surfaces]]
first = "ball"
second = "ball"
friction = 0.3
restitution = 0.5
[[surfaces]]
first = "ball"
second = "wall"
friction = 0.3
restitution = 0.5
[[particle]]
name = "ball"
material = "ball"
count = 2
radius_mm = 10
density_g_per_cm3 = 1.0
[[wall]]
name = "box"
material = "wall"
shape = "box"
low_mm = [-11, -11, 0]
high_mm = [11, 11, 40]
open = "top"
[fill]
method = "rain"
low_mm = [-11, -11, 0]
high_mm = [11, 11, 25]
interval_s = 0.001
[run]
duration_s = 0.005
output_interval_s = 0.005
)"));
  spec.time_step_fraction = 0.2;
  spec.seed = 1;
  const EngineRun run = embedded_engine().run(spec, {});
  EXPECT_EQ(run.status, RunStatus::timed_out);
  EXPECT_TRUE(run.message.starts_with("it takes more than ")) << run.message;
  EXPECT_EQ(embedded_engine().run(spec, {}).message, run.message);
}

TEST(EmbeddedEngine, ItsLargestTimeStepIsBelowTheRayleighStep) {
  const double fraction = spec_of(soft_rig()).time_step_fraction;
  EXPECT_GT(fraction, 0.01);
  EXPECT_LE(fraction, 1.0);
}

TEST(Engines, AreFoundByTheirNames) {
  EXPECT_EQ(&engine_named("embedded"), &embedded_engine());
  EXPECT_THROW(engine_named("abacus"), datasets::InputError);
}

}  // namespace
}  // namespace graintruth::calibrate
