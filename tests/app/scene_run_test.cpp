// Scenes filled and run: weight, energy, seeds, and what the door refuses.
#include "calibrate/engines/scene_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/store/input_error.h"
#include "tests/app/laboratory.h"
#include "tests/app/small_scene.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::app {
namespace {

using tests::content_of;
using tests::small_scene;
using tests::TemporaryFolder;
using tests::with;

calibrate::SceneRun run_text(const std::string& text, std::uint64_t seed = 1) {
  const TemporaryFolder folder;
  return calibrate::run_scene(datasets::load_scene(folder.write("scene.toml", text)),
                              {.seed = seed});
}

std::string refusal(const std::string& text) {
  try {
    run_text(text);
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

double weight_of(const calibrate::SceneRun& run) {
  double mass = 0.0;
  for (const sim::Body& body : run.scene.bodies) mass += run.scene.types[body.type].mass;
  return mass * 9.81;
}

const std::filesystem::path scenes =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/scenes";

// Filled, and a hundred steps on its way.
void expect_start(const std::filesystem::path& file) {
  const calibrate::SceneRun run =
      calibrate::run_scene(datasets::load_scene(file), {.seed = 1, .step_limit = 100});
  EXPECT_NE(run.status, sim::RunStatus::unstable) << file << ": " << run.message;
  EXPECT_FALSE(run.scene.bodies.empty()) << file;
}

// Enough balls for three threads, which must agree on every number that is written down.
TEST(SceneRun, IsTheSameForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const datasets::SceneFile file = datasets::load_scene(folder.write("scene.toml", R"(
title = "Balls fall into a box"
dimensions = 3
[[material]]
name = "plastic"
elastic_modulus_mpa = 10
poisson_ratio = 0.3
[[surfaces]]
first = "plastic"
second = "plastic"
friction = 0.4
restitution = 0.6
[[particle]]
name = "ball"
material = "plastic"
count = 3100
radius_mm = 5
density_g_per_cm3 = 1
[[wall]]
name = "box"
material = "plastic"
shape = "box"
low_mm = [-100, -100, 0]
high_mm = [100, 100, 400]
open = "top"
[fill]
method = "lattice"
low_mm = [-100, -100, 0]
high_mm = [100, 100, 400]
clearance_mm = 0.1
[run]
duration_s = 0.03
output_interval_s = 0.01
fastest_impact_m_per_s = 1
)"));
  const calibrate::SceneRun one = calibrate::run_scene(file, {.seed = 1, .threads = 1});
  const calibrate::SceneRun three = calibrate::run_scene(file, {.seed = 1, .threads = 3});
  ASSERT_EQ(one.frames.size(), three.frames.size());
  ASSERT_GE(one.frames.size(), 3U);
  EXPECT_GT(one.frames.back().bed.contacts, 1000);
  for (std::size_t k = 0; k < one.frames.size(); ++k) {
    const calibrate::SceneFrame &a = one.frames[k], &b = three.frames[k];
    EXPECT_EQ(a.state.position, b.state.position) << k;
    EXPECT_EQ(a.state.velocity, b.state.velocity) << k;
    EXPECT_EQ(a.energy.elastic, b.energy.elastic) << k;
    EXPECT_EQ(a.energy.friction_loss, b.energy.friction_loss) << k;
    EXPECT_EQ(a.energy.damping_loss, b.energy.damping_loss) << k;
    EXPECT_EQ(a.bed.peak_force, b.bed.peak_force) << k;
    EXPECT_EQ(a.wall_force, b.wall_force) << k;
    EXPECT_EQ(a.wall_peak, b.wall_peak) << k;
  }
}

TEST(SceneRun, EveryBundledSceneStarts) {
  int started = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
    if (entry.path().extension() != ".toml") continue;
    expect_start(entry.path());
    ++started;
  }
  EXPECT_EQ(started, 9);
}

TEST(SceneRun, EveryDeckOfTheThesisStarts) {
  const std::filesystem::path decks =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/thesis/decks";
  if (!std::filesystem::exists(decks)) GTEST_SKIP() << "the thesis is not beside the source folder";
  const TemporaryFolder folder;
  int started = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scenes / "decks")) {
    const std::string stem = entry.path().stem().string();
    folder.write(stem + ".toml", content_of(entry.path()));
    expect_start(folder.write(stem + ".txt", content_of(decks / (stem + ".txt"))));
    ++started;
  }
  EXPECT_EQ(started, 6);
}

TEST(SceneRun, SettledBedPressesWithItsWeight) {
  const calibrate::SceneRun run = run_text(small_scene());
  ASSERT_EQ(run.status, sim::RunStatus::completed) << run.message;
  ASSERT_EQ(run.phases.size(), 2u);
  EXPECT_TRUE(run.phases[0].came_to_rest);
  EXPECT_EQ(run.scene.bodies.size(), 27u);
  double upwards = 0.0;
  for (const sim::Vec3& force : run.frames.back().wall_force) upwards -= force.z();
  // Specification 14: the sum of vertical wall forces within 0.5 % of the weight
  EXPECT_NEAR(upwards / weight_of(run), 1.0, 0.005);
  // Times count from the event: the settling lies before it
  EXPECT_DOUBLE_EQ(run.frames.front().state.time, run.event_time);
  EXPECT_EQ(run.frames.size(), 3u);
}

// What the strips of the four sides carry together is what the sides carry; and no force of a frame
// is above the peak since the frame before.
TEST(SceneRun, StripsAndPeaksFitTheForcesOnTheWalls) {
  const calibrate::SceneRun run = run_text(
      with(small_scene(), "radius_mm = 10", "chain = {count = 2, radius_mm = 7, spacing_mm = 6}"));
  const calibrate::SceneFrame& last = run.frames.back();
  ASSERT_EQ(last.strip_force.size(), last.wall_force.size());
  EXPECT_NEAR(run.strips.low, 0.0, 1e-4);
  EXPECT_GT(run.strips.high, 0.03);
  double in_strips = 0.0, on_walls = 0.0;
  for (std::size_t w = 0; w < last.wall_force.size(); ++w) {
    EXPECT_GE(last.wall_peak[w], 0.0);
    if (std::abs(last.wall_force[w].z()) > 0.5 * last.wall_force[w].norm()) continue;  // the floor
    for (const double force : last.strip_force[w]) in_strips += force;
    on_walls += std::hypot(last.wall_force[w].x(), last.wall_force[w].y());
  }
  EXPECT_GT(in_strips, 0.0);
  // Horizontal friction along a side is not in the strips
  EXPECT_NEAR(in_strips / on_walls, 1.0, 0.05);
  EXPECT_GE(last.bed.peak_force, last.bed.largest_force);
}

TEST(SceneRun, SameSeedSameBitsOtherSeedOtherBed) {
  const std::string pairs = with(
      with(small_scene(), "radius_mm = 10", "chain = {count = 2, radius_mm = 7, spacing_mm = 6}"),
      "longest_s = 2.0",
      "longest_s = 0.2");
  const calibrate::SceneRun one = run_text(pairs, 7), again = run_text(pairs, 7),
                            other = run_text(pairs, 8);
  double difference = 0.0;
  for (std::size_t i = 0; i < 27; ++i) {
    EXPECT_EQ(one.scene.bodies[i].position, again.scene.bodies[i].position);
    difference += (one.scene.bodies[i].position - other.scene.bodies[i].position).norm();
  }
  EXPECT_GT(difference, 1e-3);
}

TEST(SceneRun, LedgerClosesWhileBallsFallAndABeltRuns) {
  std::string text = with(small_scene(), "duration_s = 0.02", "duration_s = 0.3");
  text = with(text, "[settle]\nlongest_s = 2.0\nrestitution = 0.2\n", "");
  text = with(text, "open = \"top\"", "open = \"top, bottom\"");
  text += R"(
[[wall]]
name = "belt"
material = "wall"
shape = "polygon"
corners_mm = [[-35, -35, 0], [35, -35, 0], [35, 35, 0], [-35, 35, 0]]
surface_velocity_mm_per_s = [300, 0, 0]
)";
  const calibrate::SceneRun run = run_text(text);
  ASSERT_EQ(run.status, sim::RunStatus::completed) << run.message;
  const sim::Energy start = run.frames.front().energy, end = run.frames.back().energy;
  const double lost = end.damping_loss + end.friction_loss;
  EXPECT_GT(lost, 1e-3);
  EXPECT_GT(end.wall_work, 0.0);
  EXPECT_NEAR(end.total() + lost - end.wall_work - start.total(), 0.0, 0.005 * lost);
}

TEST(SceneRun, APeriodThatCannotBeIsRefused) {
  const std::string cell = "dimensions = 3\n\n[periodic]\n";
  const auto said = [&](const std::string& line, const std::string& open) {
    std::string text = with(small_scene(), "dimensions = 3\n", cell + line + "\n");
    return refusal(with(text, "open = \"top\"", "open = \"" + open + "\""));
  };
  const auto expect_part = [](const std::string& sentence, const std::string& part) {
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  };
  expect_part(said("x_mm = [35, -35]", "top, left, right"), "'periodic.x_mm'");
  expect_part(said("x_mm = [-35, -5]", "top, left, right"), "period along x is 30 mm");
  expect_part(said("x_mm = [-35, 35]", "top, bottom, front, back"), "wall 'box_left'");
  expect_part(said("x_mm = [-35, 35]", "top, left, right"), "behind them, along x");
  expect_part(said("w_mm = [-35, 35]", "top"), "w_mm");
  expect_part(said("", "top"), "'periodic.x_mm' is missing");
  expect_part(said("x_mm = [nan, 35]", "top"), "'periodic.x_mm' has a number that is not finite");
  expect_part(said("x_mm = [1e12, 1000000000040]", "top, left, right"), "within 10 km");
  expect_part(said("x_mm = [-20, 35]", "top, left, right"),
              "region of [fill] goes from -35 to 35 mm");
}

// Nothing but the weight acts along a chute that is tilted and has no end.
TEST(SceneRun, GrainsFlowDownAChuteWithoutAnEnd) {
  std::string text = with(small_scene(),
                          "dimensions = 3\n",
                          "dimensions = 3\ngravity_m_per_s2 = [4.905, 0, -8.496]\n\n"
                          "[periodic]\nx_mm = [-35, 35]\ny_mm = [-35, 35]\n");
  const auto walls = text.find("[[wall]]"), fill = text.find("[fill]");
  text = text.substr(0, walls) +
         "[[wall]]\nname = \"floor\"\nmaterial = \"wall\"\nshape = \"plane\"\n"
         "point_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n" +
         text.substr(fill);
  text = with(text, "[settle]\nlongest_s = 2.0\nrestitution = 0.2\n", "");
  text = with(text, "duration_s = 0.02", "duration_s = 0.4");
  const calibrate::SceneRun run = run_text(text);
  ASSERT_EQ(run.status, sim::RunStatus::completed) << run.message;
  const sim::Energy start = run.frames.front().energy, end = run.frames.back().energy;
  const double lost = end.damping_loss + end.friction_loss;
  EXPECT_NEAR(end.total() + lost - start.total(), 0.0, 0.005 * lost);
  EXPECT_LT(end.gravity, start.gravity);
  for (const sim::Vec3& position : run.frames.back().state.position) {
    EXPECT_LE(std::abs(position.x()), 0.035);
    EXPECT_LE(std::abs(position.y()), 0.035);
    EXPECT_GT(position.z(), 0.009);
  }
}

TEST(SceneRun, RainFillsOneByOne) {
  std::string text =
      with(small_scene(), "method = \"lattice\"", "method = \"rain\"\ninterval_s = 0.02");
  text = with(text, "count = 27", "count = 12");
  const calibrate::SceneRun run = run_text(text);
  ASSERT_EQ(run.status, sim::RunStatus::completed) << run.message;
  EXPECT_EQ(run.scene.bodies.size(), 12u);
  ASSERT_EQ(run.phases.size(), 3u);
  EXPECT_EQ(run.phases[0].name, "rain");
  EXPECT_TRUE(run.phases[1].came_to_rest);
  for (const sim::Body& body : run.scene.bodies) {
    EXPECT_LT(std::abs(body.position.x()), 0.0255);
    EXPECT_GT(body.position.z(), 0.0095);
    EXPECT_LT(body.position.z(), 0.07);
  }
}

TEST(SceneRun, PanelOpensAtItsTimeAndTheDischargeIsCounted) {
  std::string text = with(small_scene(), "duration_s = 0.02", "duration_s = 0.4");
  text = with(text, "output_interval_s = 0.01", "output_interval_s = 0.1\nexit_height_mm = -50");
  text = with(text, "open = \"top\"", "open = \"top, bottom\"");
  text += R"(
[[wall]]
name = "panel"
material = "wall"
shape = "disk"
centre_mm = [0, 0, 0]
normal = [0, 0, 1]
radius_mm = 60
opens_s = 0.1
)";
  const calibrate::SceneRun run = run_text(text);
  ASSERT_EQ(run.frames.size(), 5u);
  EXPECT_EQ(run.frames[1].bed.discharged, 0);
  EXPECT_EQ(run.frames[4].bed.discharged, 27);
  EXPECT_NEAR(run.frames[4].bed.discharged_mass * 9.81, weight_of(run), 1e-12);
}

TEST(SceneRun, SizesHaveTheirMeanAndSpread) {
  for (const char* kind : {"uniform", "normal", "lognormal"}) {
    const TemporaryFolder folder;
    const auto file = folder.write("scene.toml",
                                   with(small_scene(),
                                        "radius_mm = 10",
                                        std::string("radius_mm = 10\nsize = {distribution = \"") +
                                            kind + "\", standard_deviation = 0.1, classes = 9}"));
    const calibrate::BuiltScene built =
        calibrate::build_scene(datasets::load_scene(file), "scene.toml");
    ASSERT_EQ(built.kinds[0].types.size(), 9u);
    double mean = 0.0, square = 0.0;
    for (const int type : built.kinds[0].types) {
      const double radius = built.scene.types[type].spheres[0].radius / 0.01;
      mean += radius / 9.0;
      square += radius * radius / 9.0;
      EXPECT_NEAR(built.scene.types[type].mass / built.scene.types[type].volume, 1000.0, 1e-9);
    }
    EXPECT_NEAR(mean, 1.0, 1e-12) << kind;
    EXPECT_NEAR(std::sqrt(square - mean * mean), 0.1, 1e-12) << kind;
  }
}

TEST(SceneRun, PhaseSetsFrictionOnlyForItself) {
  const TemporaryFolder folder;
  const auto scene = datasets::load_scene(folder.write(
      "scene.toml", with(small_scene(), "restitution = 0.2", "restitution = 0.2\nfriction = 0.0")));
  sim::SurfaceTable surfaces;
  calibrate::use_surfaces(scene, scene.phases[0], surfaces);
  EXPECT_EQ(surfaces.of(0, 0).friction, 0.0);
  EXPECT_EQ(surfaces.of(0, 1).restitution, 0.2);
  calibrate::use_surfaces(scene, scene.phases[1], surfaces);
  EXPECT_EQ(surfaces.of(0, 1).friction, 0.3);
  EXPECT_EQ(surfaces.of(0, 0).restitution, 0.5);
}

// A ball rolls to a stop by rolling friction alone, from the key to the physics; and the words of
// [law] reach the simulator.
TEST(SceneRun, RollingFrictionAndTheFormOfTheLawAreUsed) {
  std::string text = with(small_scene(), "count = 27", "count = 0");
  text = with(text, "[settle]\nlongest_s = 2.0\nrestitution = 0.2\n", "");
  text = with(text, "duration_s = 0.02", "duration_s = 0.1");
  text = with(text,
              "shape = \"box\"\nlow_mm = [-35, -35, 0]\nhigh_mm = [35, 35, 200]\nopen = \"top\"\n",
              "shape = \"plane\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n");
  text +=
      "\n[[place]]\nparticle = \"ball\"\nx_mm = 0\nz_mm = 10\nvelocity_mm_per_s = [200, 0, 0]\n"
      "spin_rad_per_s = [0, 20, 0]\n";
  const std::string rolls =
      with(text, "second = \"wall\"\n", "second = \"wall\"\nrolling_friction = 0.1\n");
  const auto speed = [](const calibrate::SceneRun& run) {
    return run.scene.bodies.at(0).velocity.x();
  };
  EXPECT_NEAR(speed(run_text(text)), 0.2, 1e-3);
  EXPECT_NEAR(speed(run_text(rolls)), 0.2 - 5.0 / 7.0 * 0.1 * 9.81 * 0.1, 1e-3);
  EXPECT_NEAR(run_text(text).contacts.at(0).overlap /
                  run_text(text + "\n[law]\nnormal_spring = \"secant\"\n").contacts.at(0).overlap,
              std::pow(1.5, 2.0 / 3.0),
              2e-2);
}

TEST(SceneDoor, NamesWhatTheLawDoesNotKnow) {
  const auto law = [](const std::string& line) {
    return refusal(small_scene() + "\n[law]\n" + line + "\n");
  };
  EXPECT_NE(law("normal_spring = \"herz\"")
                .find("is 'herz', but must be one of hertz, linear, secant, incremental"),
            std::string::npos);
  EXPECT_NE(law("normal_spring = \"linear\"").find("linear_stiffness"), std::string::npos);
  EXPECT_NE(law("linear_stiffness_n_per_m = 1e4").find("belongs to another spring"),
            std::string::npos);
  EXPECT_NE(refusal(with(small_scene(), "friction = 0.3", "friction = 0.3\nstatic_friction = 0.2"))
                .find("must not be below friction"),
            std::string::npos);
}

TEST(SceneDoor, NamesParticlesThatCannotBeWhereTheyAre) {
  const std::string empty = with(small_scene(), "count = 27", "count = 0");
  const auto place = [&](const std::string& where) {
    return empty + "\n[[place]]\nparticle = \"ball\"\n" + where;
  };
  EXPECT_NE(refusal(place("x_mm = 30\nz_mm = 50\n")).find("overlaps wall 'box_right'"),
            std::string::npos);
  const std::string floor =
      "\n[[wall]]\nname = \"ground\"\nmaterial = \"wall\"\nshape = \"plane\"\npoint_mm = [0, 0, "
      "-50]\nnormal = [0, 0, 1]\n";
  EXPECT_NE(refusal(place("x_mm = 90\nz_mm = -90\n") + floor).find("lies behind wall 'ground'"),
            std::string::npos);
  const std::string second = "\n[[place]]\nparticle = \"ball\"\nx_mm = 12\nz_mm = 50\n";
  EXPECT_NE(refusal(place("x_mm = 0\nz_mm = 50\n") + second).find("particle 2"), std::string::npos);
  EXPECT_NE(refusal(with(small_scene(), "count = 27", "count = 500")).find("of 500 particles"),
            std::string::npos);
}

// Under the slopes of a hopper there is room for a lattice, but nothing could have come there.
TEST(Lattice, StandsOnlyWhereParticlesCanFall) {
  std::string text = with(small_scene(), "dimensions = 3", "dimensions = 2");
  text =
      with(text,
           "shape = \"box\"\nlow_mm = [-35, -35, 0]\nhigh_mm = [35, 35, 200]\nopen = \"top\"\n",
           "shape = \"segment\"\nfrom_mm = [0, 0]\nto_mm = [-300, 300]\n\n[[wall]]\nname = "
           "\"right\"\nmaterial = \"wall\"\nshape = \"segment\"\nfrom_mm = [0, 0]\nto_mm = [300, "
           "300]\n");
  text = with(text,
              "low_mm = [-35, -35, 0]\nhigh_mm = [35, 35, 200]",
              "low_mm = [-200, 0]\nhigh_mm = [200, 300]");
  text = with(text, "longest_s = 2.0", "longest_s = 0.01");
  const calibrate::SceneRun run = run_text(text);
  for (const sim::Body& body : run.scene.bodies) {
    EXPECT_GT(body.position.z(), std::abs(body.position.x()));
  }
}

}  // namespace
}  // namespace graintruth::app
