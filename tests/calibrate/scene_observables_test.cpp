// Observables of a scene as a rig, by closed forms of a bed at rest.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calibrate/problem.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr int grains = 200;
constexpr double radius = 0.005, density = 1200.0, side = 0.05;  // m, kg/m3, m
const double mass = grains * density * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);

// Balls in a box, as they have settled.
constexpr const char* box = R"(
title = "Balls in a box"
dimensions = 3
[[material]]
name = "ball"
elastic_modulus_mpa = 5
poisson_ratio = 0.3
[[material]]
name = "wall"
rigid = true
[[surfaces]]
first = "ball"
second = "ball"
friction = 0.3
restitution = 0.3
[[surfaces]]
first = "ball"
second = "wall"
friction = 0.0
restitution = 0.3
[[particle]]
name = "ball"
material = "ball"
count = 200
density_g_per_cm3 = 1.2
radius_mm = 5
[[wall]]
name = "floor"
material = "wall"
shape = "plane"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[wall]]
name = "left"
material = "wall"
shape = "plane"
point_mm = [-25, 0, 0]
normal = [1, 0, 0]
[[wall]]
name = "right"
material = "wall"
shape = "plane"
point_mm = [25, 0, 0]
normal = [-1, 0, 0]
[[wall]]
name = "front"
material = "wall"
shape = "plane"
point_mm = [0, -25, 0]
normal = [0, 1, 0]
[[wall]]
name = "back"
material = "wall"
shape = "plane"
point_mm = [0, 25, 0]
normal = [0, -1, 0]
[fill]
method = "rain"
low_mm = [-25, -25, 0]
high_mm = [25, 25, 150]
interval_s = 0.004
speed_m_per_s = 1
[settle]
longest_s = 2
[run]
duration_s = 0.2
output_interval_s = 0.05
fastest_impact_m_per_s = 1
)";

// The experiment whose replicates have a table of this content.
struct BoxExperiment {
  BoxExperiment(const std::string& measure, const std::string& table) {
    folder.write("box.toml", box);
    folder.write("table.csv", table);
    const auto file = folder.write("experiment.toml", R"(title = "A box"
[rig]
kind = "scene"
scene = "box.toml"
[tune]
restitution = {}
[[replicate]]
name = "one"
curves = "table.csv"
[[replicate]]
name = "two"
curves = "table.csv"
[measure]
frame_interval_s = 0.05
frames = 4
)" + measure);
    experiment = datasets::load_experiment(file);
    complete_particle(experiment);
  }

  std::string complaint() const {
    try {
      const Observables observables(experiment);
    } catch (const datasets::InputError& error) {
      return error.what();
    }
    return "";
  }

  tests::TemporaryFolder folder;
  datasets::Experiment experiment;
};

// Of the first observable, simulated.
Channel simulated(const BoxExperiment& made) {
  const std::vector<datasets::Recording> recordings(2);
  const Problem problem = plan_problem(made.experiment, recordings);
  const EngineRun run = problem.engine->run(
      problem.spec_of(0, datasets::bench_parameters(made.experiment), 0.2, 1), {});
  EXPECT_EQ(run.status, RunStatus::completed) << run.message;
  const Situation situation{.particle = made.experiment.particle,
                            .rig = made.experiment.replicates.front().rig,
                            .measurement = made.experiment.measurement};
  return problem.observables->measure(run.recording, situation).front();
}

void expect_refusal(const BoxExperiment& made, const std::vector<std::string>& parts) {
  const std::string said = made.complaint();
  for (const std::string& part : parts) EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(WallForce, OfAFloorIsTheWeightOfWhatRestsOnIt) {
  const BoxExperiment made(
      "observables = [\"wall_force\"]\n[measure.wall_force]\nwall = \"floor\"\naxis = \"z\"\n",
      "time_s,wall_force_n\n0,1\n1,1\n");
  const Channel force = simulated(made);
  ASSERT_EQ(force.values.size(), 4U);
  // Downwards; the bed still swings a little where the run begins
  for (std::size_t i = 1; i < force.values.size(); ++i)
    EXPECT_NEAR(force.values[i], -mass * 9.81, 0.02 * mass * 9.81);
}

TEST(WallForce, OfNoWallOrNoDirectionIsRefused) {
  const std::string asked = "observables = [\"wall_force\"]\n", table = "wall_force_n\n1\n";
  expect_refusal(BoxExperiment(asked, table),
                 {"experiment.toml", "[measure.wall_force]", "wall = "});
  expect_refusal(
      BoxExperiment(asked + "[measure.wall_force]\nwall = \"lid\"\naxis = \"z\"\n", table),
      {"experiment.toml:18", "'measure.wall_force.wall'", "'lid'", "floor, left, right, front"});
  expect_refusal(
      BoxExperiment(asked + "[measure.wall_force]\nwall = \"floor\"\naxis = \"up\"\n", table),
      {"experiment.toml:19", "'measure.wall_force.axis'", "\"z\""});
  expect_refusal(
      BoxExperiment(asked + "[measure.wall_force]\nwall = \"floor\"\naxs = \"z\"\n", table),
      {"experiment.toml:17", "'measure.wall_force.axis'", "is missing"});
}

constexpr const char* of_the_box =
    "observables = [\"bulk_density\"]\n[measure.bulk_density]\nwidth_mm = 50\ndepth_mm = 50\n";

// Two layers, of which the upper one is half full: h = 2 <z>.
TEST(BulkDensity, IsTheMassOfTheGrainsOverTheVolumeOfTheBed) {
  const BoxExperiment made(of_the_box, "bulk_density_kg_per_m3\n700\n");
  datasets::Trajectories tracks = datasets::make_trajectories(1, 100, false);
  double sum = 0.0;
  for (std::size_t i = 0; i < tracks.poses.size(); ++i) {
    tracks.poses[i].z = i < 60 ? radius : 3.0 * radius;
    sum += tracks.poses[i].z;
  }
  const Situation situation{.particle = made.experiment.particle,
                            .rig = made.experiment.replicates.front().rig,
                            .measurement = made.experiment.measurement};
  const Observables observables(made.experiment);
  const datasets::Recording recording{.tracks = tracks};
  const Channel channel = observables.all().front()->measure(recording, situation);
  const double expected = 0.5 * mass / (side * side * 2.0 * sum / 100.0);
  ASSERT_EQ(channel.values.size(), 1U);
  EXPECT_NEAR(channel.values.front(), expected, 1e-9 * expected);
}

// Balls that fall into a box take 55 to 64 % of its volume, less beside walls.
TEST(BulkDensity, OfBallsInABoxIsThatOfLooseOrDensePacking) {
  const BoxExperiment made(of_the_box, "bulk_density_kg_per_m3\n700\n");
  const double share = simulated(made).values.front() / density;
  EXPECT_GT(share, 0.48);
  EXPECT_LT(share, 0.64);
}

// No bed is as dense as its grains, and a number in g/cm3 is none in kg/m3.
TEST(BulkDensity, ThatContradictsTheGrainsIsTold) {
  BoxExperiment made(of_the_box, "bulk_density_kg_per_m3\n700\n");
  complete_particle(made.experiment);
  const Situation situation{.particle = made.experiment.particle,
                            .rig = made.experiment.replicates.front().rig,
                            .measurement = made.experiment.measurement};
  const Observables observables(made.experiment);
  const auto said = [&](double value) {
    return observables.all().front()->contradiction(Channel{.values = {value}}, situation);
  };
  for (const double possible : {0.2 * density, 0.6 * density, 0.9 * density})
    EXPECT_EQ(said(possible), "") << possible;
  for (const double impossible : {1.05 * density, 2.0 * density, 0.6e-3 * density, 0.6e3 * density})
    EXPECT_NE(said(impossible).find("look at the units"), std::string::npos) << impossible;
  EXPECT_EQ(observables.all().front()->contradiction(Channel{}, situation), "");
}

TEST(BulkDensity, OfNoContainerIsRefused) {
  const std::string asked = "observables = [\"bulk_density\"]\n", table = "force_n\n1\n";
  expect_refusal(BoxExperiment(asked, table),
                 {"experiment.toml", "[measure.bulk_density]", "diameter_mm"});
  expect_refusal(BoxExperiment(asked + "[measure.bulk_density]\nwidth_mm = 50\n", table),
                 {"experiment.toml:17", "'measure.bulk_density.depth_m'", "is missing"});
  expect_refusal(BoxExperiment(asked + "[measure.bulk_density]\ndiameter_mm = 0\n", table),
                 {"experiment.toml:18", "'measure.bulk_density.diameter_mm'", "above 0"});
}

}  // namespace
}  // namespace graintruth::calibrate
