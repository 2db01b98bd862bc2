#include "sim/simulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

Scene relaxed_rig() {
  Scene scene = scenes::micro_rig();
  relax_overlaps(scene);
  return scene;
}

TEST(Determinism, SameInputSameBits) {
  for (const bool planar : {true, false}) {
    Scene scene = relaxed_rig();
    scene.planar = planar;
    Simulation first(scene), second(scene);
    first.run_until(0.3);
    second.run_until(0.3);
    EXPECT_EQ(first.state_hash(), second.state_hash());
    Simulation other(scene, {.time_step = {.fraction = 0.25}});
    other.run_until(0.3);
    EXPECT_NE(first.state_hash(), other.state_hash());
  }
}

TEST(Determinism, WatchingChangesNothing) {
  const Scene scene = relaxed_rig();
  Simulation quiet(scene), watched(scene);
  quiet.run_until(0.2, {.interval = 0.02});
  watched.run_until(0.2, {.interval = 0.02, .observer = [&](const State&) {
                            (void)watched.contacts();
                            (void)watched.energy();
                          }});
  EXPECT_EQ(quiet.state_hash(), watched.state_hash());
}

TEST(Sampling, ObserverIsCalledAtWholeMultiples) {
  Simulation simulation(relaxed_rig());
  std::vector<double> times;
  simulation.run_until(
      0.1, {.interval = 0.02, .observer = [&](const State& s) { times.push_back(s.time); }});
  ASSERT_EQ(times.size(), 6u);
  for (std::size_t i = 0; i < times.size(); ++i)
    EXPECT_NEAR(times[i], 0.02 * static_cast<double>(i), 1e-12);
}

Scene one_ball(double velocity) {
  Scene scene;
  scene.planar = true;
  const int material = scene.add_material({1e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = 0.3, .restitution = 0.5});
  const int ball = scene.add_type(make_clump(chain_of_spheres(1, 0.01, 0.0), {.density = 2000.0}));
  scene.add_planar_body(ball, {0.0, 0.01}, 0.0, {0.0, velocity});
  scene.add_wall(segment_wall({-0.1, 0.0}, {0.1, 0.0}, {}, rigid));
  return scene;
}

TEST(Piston, CarriesABodyAtItsSpeed) {
  for (const double speed : {-0.046, 0.1}) {
    Scene scene = one_ball(0.0);
    scene.walls[0].motion = {.velocity = {0.0, 0.0, speed}, .start_time = 0.2};
    Simulation simulation(scene);
    simulation.run_until(0.2);
    const double rest = simulation.state().position[0].z();
    ASSERT_EQ(simulation.run_until(1.2).status, RunStatus::completed);
    EXPECT_NEAR(simulation.state().velocity[0].z(), speed, 1e-6);
    EXPECT_NEAR(simulation.state().position[0].z(), rest + speed, 1e-7);
  }
}

TEST(Conveyor, DragsABodyAtTheSpeedOfFriction) {
  Scene scene = one_ball(0.0);
  scene.walls[0] = plane_wall(Vec3::Zero(), Vec3::UnitZ(), {.velocity = {1.0, 0.0, 0.0}}, 1);
  Simulation simulation(scene);
  simulation.run_until(0.05);
  EXPECT_NEAR(simulation.state().velocity[0].x(), 0.3 * 9.81 * 0.05, 5e-3 * 0.147);
}

TEST(Guard, TooFastABodyIsUnstable) {
  Simulation simulation(one_ball(1e6));
  const RunSummary summary = simulation.run_until(0.1);
  EXPECT_EQ(summary.status, RunStatus::unstable);
  EXPECT_NE(summary.message.find("body 0"), std::string::npos) << summary.message;
  EXPECT_TRUE(simulation.state().position[0].allFinite());
  EXPECT_TRUE(simulation.state().velocity[0].allFinite());
}

std::string refusal_of(const Scene& scene) {
  try {
    Simulation simulation(scene);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(Guard, DeepOverlapAtTheStartIsRefused) {
  Scene scene = one_ball(0.0);
  scene.bodies[0].position.z() = 0.0091;  // 9 % of the radius of 1 cm
  EXPECT_EQ(refusal_of(scene), "");
  for (const double height : {0.0089, 0.008, 0.0}) {
    scene.bodies[0].position.z() = height;
    EXPECT_NE(refusal_of(scene).find("body 0 overlaps wall 0"), std::string::npos) << height;
  }
}

// A soft ball hits a wall: no step is too long, but the contact becomes too deep.
TEST(Guard, DeepOverlapOnTheWayIsUnstable) {
  Scene scene = one_ball(-2.0);
  scene.materials[0].youngs_modulus = 1e5;
  Simulation simulation(scene, {.time_step = {.largest = 1e-4}});
  const RunSummary summary = simulation.run_until(0.1);
  EXPECT_EQ(summary.status, RunStatus::unstable);
  EXPECT_NE(summary.message.find("wall 0"), std::string::npos) << summary.message;
  EXPECT_TRUE(simulation.state().velocity[0].allFinite());
}

TEST(Limits, StepsAndCallerEndARun) {
  Simulation limited(one_ball(0.0), {.largest_step_count = 100});
  RunSummary summary = limited.run_until(1.0);
  EXPECT_EQ(summary.status, RunStatus::timed_out);
  EXPECT_EQ(summary.steps, 100);
  Simulation stopped(one_ball(0.0));
  summary = stopped.run_until(1.0, {.should_stop = [] { return true; }});
  EXPECT_EQ(summary.status, RunStatus::timed_out);
}

TEST(Phases, SurfacesChangeWithoutLosingTheState) {
  Simulation simulation(relaxed_rig());
  simulation.set_global_damping(20.0);
  simulation.set_surfaces(0, 0, {.friction = 0.5, .restitution = 0.2});
  simulation.run_until(0.2);
  const State before = simulation.state();
  simulation.set_global_damping(0.0);
  simulation.set_surfaces(0, 0, {.friction = 0.1, .restitution = 0.85});
  simulation.clear_velocities();
  for (std::size_t i = 0; i < before.position.size(); ++i) {
    EXPECT_EQ(before.position[i], simulation.state().position[i]);
    EXPECT_EQ(simulation.state().velocity[i], Vec3(Vec3::Zero()));
  }
  EXPECT_EQ(simulation.run_until(0.4).status, RunStatus::completed);
}

TEST(MicroRig, SettlesAndRunsThrough) {
  Simulation simulation(relaxed_rig(), {.time_step = {.fraction = 1.0}});
  const RunSummary summary = simulation.run_until(4.8, {.interval = 0.2});
  ASSERT_EQ(summary.status, RunStatus::completed) << summary.message;
  // The piston has sunk 0.21 m into a column of 0.28 m: every body is above it and inside the rig
  const Scene end = simulation.scene_now();
  for (const Vec3& position : simulation.state().position) {
    EXPECT_GT(position.z(), end.walls[4].from.y());
    EXPECT_LT(std::abs(position.x()), 0.2);
  }
  EXPECT_NEAR(end.walls[4].from.y(), -0.046 * 4.6, 1e-12);
}

TEST(Scene, RefusesWhatCannotBe) {
  Scene scene = one_ball(0.0);
  scene.bodies[0].type = 3;
  EXPECT_THROW(Simulation{scene}, std::invalid_argument);
  scene = one_ball(0.0);
  scene.bodies[0].velocity.x() = NAN;
  EXPECT_THROW(Simulation{scene}, std::invalid_argument);
  scene = one_ball(0.0);
  scene.walls[0].material = 9;
  EXPECT_THROW(Simulation{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
