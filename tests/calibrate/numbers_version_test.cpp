// Golden values of closed models. Simulations and tracks are read back under the version of the
// numbers that made them: who changes the numbers bumps the version, or old results are taken for
// new ones.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "calibrate/engines/embedded.h"
#include "calibrate/problem.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr const char* version = "9";
constexpr const char* bump_it =
    "The embedded engine gives other numbers for the same spec: bump it, numbers_version in "
    "calibrate/engines/embedded.cpp, and renew the golden values of this test.";

// A clump that falls on a tilted floor beside a wall, with everything that a law has: friction,
// static and rolling friction, restitution, and a floor that moves.
SimulationSpec falling_clump(int dimensions) {
  const tests::TemporaryFolder folder;
  const auto file = folder.write("scene.toml", R"(
title = "A clump on a slope"
dimensions = )" + std::to_string(dimensions) + R"(
[[material]]
name = "grain"
elastic_modulus_mpa = 20
poisson_ratio = 0.3
[[material]]
name = "wall"
rigid = true
[[surfaces]]
first = "grain"
second = "wall"
friction = 0.3
static_friction = 0.4
rolling_friction = 0.05
restitution = 0.6
[[surfaces]]
first = "grain"
second = "grain"
friction = 0.2
restitution = 0.7
[[particle]]
name = "clump"
material = "grain"
count = 0
density_g_per_cm3 = 1.2
spheres = [{x_mm = -4, radius_mm = 5}, {x_mm = 4, radius_mm = 6}]
[[wall]]
name = "slope"
material = "wall"
shape = "plane"
point_mm = [0, 0, 0]
normal = [0.3, 0, 1]
velocity_mm_per_s = [0, 0, 20]
[[wall]]
name = "side"
material = "wall"
shape = "plane"
point_mm = [60, 0, 0]
normal = [-1, 0, 0]
[[place]]
particle = "clump"
x_mm = 0
z_mm = 12
angle_deg = 20
spin_rad_per_s = [0, 5, 0]
[[place]]
particle = "clump"
x_mm = 1
z_mm = 30
[run]
duration_s = 0.2
output_interval_s = 0.02
time_step_fraction = 0.2
)");
  SimulationSpec spec;
  spec.scene = datasets::load_scene(file);
  spec.time_step_fraction = 0.2;
  return spec;
}

// Mathematical functions of another machine differ in their last bit; ten contacts keep that small.
void expect_golden(double value, double golden, const char* whose) {
  EXPECT_NEAR(value, golden, 1e-9 * std::max(1.0, std::abs(golden))) << whose;
}

TEST(NumbersVersion, OfTheEmbeddedEngineGoesWithItsNumbers) {
  struct Golden {
    int dimensions;
    double x, z, angle, other_x, other_z;  // m, rad; after 0.2 s
  };
  for (const Golden& golden : {Golden{2,
                                      0.0247698136420172,
                                      0.00250429314911627,
                                      -0.180962858318553,
                                      0.00893872791078817,
                                      0.0100369452612743},
                               Golden{3,
                                      0.0247698136420206,
                                      0.00250429314911575,
                                      0.0,
                                      0.00893872791079505,
                                      0.0100369452612769}}) {
    const EngineRun run = embedded_engine().run(falling_clump(golden.dimensions), {});
    ASSERT_EQ(run.status, RunStatus::completed) << run.message;
    const datasets::Trajectories& tracks = *run.recording.tracks;
    const datasets::Pose& first = tracks.poses[tracks.index(tracks.frames() - 1, 0)];
    const datasets::Pose& second = tracks.poses[tracks.index(tracks.frames() - 1, 1)];
    expect_golden(first.x, golden.x, bump_it);
    expect_golden(first.z, golden.z, bump_it);
    if (golden.dimensions == 2) expect_golden(first.angle, golden.angle, bump_it);
    expect_golden(second.x, golden.other_x, bump_it);
    expect_golden(second.z, golden.other_z, bump_it);
  }
  EXPECT_EQ(embedded_engine().version(), version)
      << "The version is another: renew the golden values of this test, and its version.";
}

// Where grains begin is drawn: from what films tell of a start, and in a filling.
TEST(NumbersVersion, OfTheEmbeddedEngineGoesWithWhatItDraws) {
  SimulationSpec spec = falling_clump(2);
  spec.seed = 3;
  spec.start = {{{0.0, 0.05, 0.1}, {0.03, 0.05, 0.2}}, {1e-3, 1e-3, 0.05}};
  spec.scene.places.clear();
  const EngineRun placed = embedded_engine().run(spec, {});
  ASSERT_EQ(placed.status, RunStatus::completed) << placed.message;
  const datasets::Pose& drawn = placed.recording.tracks->poses[1];
  expect_golden(drawn.x, 0.0304843733367019, bump_it);
  expect_golden(drawn.z, 0.0508430348956025, bump_it);
  expect_golden(drawn.angle, 0.168746338926776, bump_it);

  SimulationSpec filled;
  filled.seed = 3;
  filled.time_step_fraction = 0.2;
  filled.scene = datasets::load_scene(GRAINTRUTH_SOURCE_DIR "/datasets/scenes/box_3d.toml");
  for (datasets::SceneParticle& particle : filled.scene.particles)
    particle.count = std::min(particle.count, 8);
  filled.scene.phases.back().duration = filled.scene.phases.back().output_interval;
  const EngineRun run = embedded_engine().run(filled, {});
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  double sum = 0.0;
  for (const datasets::Pose& pose : run.recording.tracks->poses) sum += pose.x + 2.0 * pose.z;
  expect_golden(sum, 0.446914648188122, bump_it);
}

constexpr int measured_by = 3;
constexpr const char* bump_measuring =
    "An observable gives other numbers for the same recording: bump it, measuring_version in "
    "calibrate/problem.h, and renew the golden values of this test.";

// Three hundred grains of a bed that sinks the faster the nearer it is to the middle, and leaves.
datasets::Recording sinking_bed() {
  datasets::Recording recording;
  datasets::Trajectories tracks = datasets::make_trajectories(301, 300, false);
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    tracks.time[frame] = 0.01 * static_cast<double>(frame);
    for (std::size_t i = 0; i < 300; ++i) {
      const auto grain = static_cast<double>(i);
      const double x = 0.012 * (static_cast<double>(i % 6) - 2.5) + 0.004 * std::sin(grain);
      const double z = 0.01 + 0.002 * grain;
      const double sunk = 0.1 * std::exp(-500.0 * x * x) * tracks.time[frame];
      tracks.poses[tracks.index(frame, i)] = {x, z - sunk, 0.1 * static_cast<double>(i)};
    }
  }
  recording.tracks = tracks;
  recording.curves["force_n"] = {.time = {0.0, 1.0, 3.0}, .value = {1.0, 2.0, 0.5}};
  return recording;
}

TEST(NumbersVersion, OfMeasuringGoesWithWhatObservablesMeasure) {
  const tests::TemporaryFolder folder;
  folder.write("curve.csv", "time_s,mass_kg\n0,0\n1,0\n");
  const auto file = folder.write("bin.toml", R"(title = "A bed"
[particle]
count = 300
mass_g = 0.3
plate = {semi_major_mm = 6.0, semi_minor_mm = 5.0, thickness_mm = 2.3}
[material]
elastic_modulus_gpa = 3.5
poisson_ratio = 0.3
friction_particle_particle = 0.5
friction_particle_wall = 0.4
restitution = 0.8
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 80
bin_height_mm = 400
front_back_gap_mm = 2.6
orifice_width_mm = 30
[measure]
frame_interval_s = 0.1
frames = 20
observables = ["tracks", "heap_height", "discharge_rate", "what_stays", "velocity_profile", "force"]
[measure.force]
column = "force_n"
engine_curve = "wall_force_side_left_x_n"
unit = "N"
[tune]
friction_particle_particle = {}
[[replicate]]
name = "one"
discharge = "curve.csv"
[[replicate]]
name = "two"
discharge = "curve.csv"
)");
  const datasets::Experiment experiment = datasets::load_experiment(file);
  const Observables observables(experiment);
  const Situation situation{.particle = experiment.particle,
                            .rig = experiment.replicates.front().rig,
                            .measurement = experiment.measurement};
  const std::vector<Channel> channels = observables.measure(sinking_bed(), situation);
  const std::map<std::string, double> golden = {{"tracks", 8412139.77389968},
                                                {"heap_height", 11.9364751404931},
                                                {"discharge_rate", 0.0131409591010406},
                                                {"flowing_density", 1.96806091651214},
                                                {"beverloo", 0.0},  // of several orifices
                                                {"what_stays", 179.0},
                                                {"velocity_profile", 0.579523692425186},
                                                {"kinematic", 0.0},  // of several replicates
                                                {"force", 34.1846875}};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::string name = observables.all()[i]->name();
    double sum = 0.0;
    for (std::size_t k = 0; k < channels[i].values.size(); ++k) {
      if (std::isfinite(channels[i].values[k]))
        sum += channels[i].values[k] * (1.0 + 0.01 * static_cast<double>(k));
    }
    EXPECT_TRUE(golden.contains(name)) << name;
    if (golden.contains(name)) expect_golden(sum, golden.at(name), bump_measuring);
  }
  EXPECT_EQ(measuring_version, measured_by) << "Renew the golden values of this test.";
}

}  // namespace
}  // namespace graintruth::calibrate
