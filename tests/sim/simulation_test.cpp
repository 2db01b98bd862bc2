#include "sim/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "sim/engine/contact_summary.h"
#include "tests/sim/hashed_runs.h"

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

// Release, debug and sanitized builds all run this, so all of them give these bits. When results
// change on purpose, bench_sim_state_hash prints the new ones.
TEST(Determinism, EveryBuildGivesTheSameBits) {
  const std::uint64_t expected[] = {0x6342f513aa4200f8,
                                    0x7122a58747387f54,
                                    0xae1ce04392f4cd8c,
                                    0xf96b09759daaf858,
                                    0xde6bd92eded5d04d,
                                    0xd07dad02d0182895,
                                    0x5e9b54efa4e59b69};
  const std::vector<HashedRun> runs = hashed_runs();
  ASSERT_EQ(runs.size(), std::size(expected));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(runs[i].hash(), expected[i]) << runs[i].name;
  }
}

TEST(Determinism, RestartGivesTheSameBits) {
  for (const HashedRun& run : hashed_runs()) {
    Simulation whole(run.scene, run.options);
    whole.run_until(0.5 * run.duration);
    const Snapshot snapshot = whole.save();
    whole.run_until(0.7 * run.duration);
    Simulation restarted(run.scene, run.options);
    restarted.restore(snapshot);
    restarted.run_until(0.7 * run.duration);
    EXPECT_EQ(restarted.state_hash(), whole.state_hash()) << run.name;
  }
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

// A hard impact lasts a few microseconds: a look every millisecond misses it, the running maximum
// does not. By Hertz F = (4/3) E* sqrt(R) d^1.5 with d = (5 m v^2/(4 k))^(2/5).
TEST(Peaks, OfAnImpactAreNotLost) {
  Scene scene = one_ball(-0.5);
  scene.gravity.setZero();
  scene.surfaces.set(0, 1, {.restitution = 1.0});
  scene.bodies[0].position.z() = 0.0101;
  Simulation simulation(scene, {.time_step = {.fraction = 0.1}, .keep_peaks = true});
  double seen = 0.0;
  simulation.run_until(0.01, {.interval = 1e-3, .observer = [&](const State&) {
                                for (const ContactReport& c : simulation.contacts())
                                  seen = std::max(seen, c.normal_force);
                              }});
  const double k = 4.0 / 3.0 * 1e9 / (1.0 - 0.09) * std::sqrt(0.01);
  const double deepest = std::pow(5.0 * scene.types[0].mass * 0.25 / (4.0 * k), 0.4);
  const double exact = k * std::pow(deepest, 1.5);
  const ContactPeaks peaks = simulation.take_peaks();
  EXPECT_LT(seen, 0.5 * exact);
  EXPECT_NEAR(peaks.normal_force / exact, 1.0, 1e-3);
  EXPECT_EQ(peaks.of_body.at(0), peaks.normal_force);
  EXPECT_EQ(peaks.of_wall.at(0), peaks.normal_force);
  EXPECT_TRUE(peaks.with_wall);
  EXPECT_GT(peaks.time, 0.0);
  EXPECT_LT(peaks.time, 0.001);
  EXPECT_EQ(simulation.take_peaks().normal_force, 0.0);  // taken
}

TEST(Peaks, LookingForThemChangesNothing) {
  const Scene scene = relaxed_rig();
  Simulation plain(scene), watched(scene, {.keep_peaks = true});
  plain.run_until(0.1);
  watched.run_until(0.1);
  EXPECT_EQ(plain.state_hash(), watched.state_hash());
  EXPECT_GT(watched.take_peaks().normal_force, 0.0);
}

// Two rows of three balls lie on each other in a corner: nine contacts, but three partners.
TEST(Partners, CountOnceForManyContacts) {
  Scene scene;
  scene.planar = true;
  const int material = scene.add_material({1e8, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = 0.5, .restitution = 0.3});
  scene.surfaces.set(material, material, {.friction = 0.5, .restitution = 0.3});
  const int row = scene.add_type(make_clump(chain_of_spheres(3, 0.01, 0.02), {.density = 1e3}));
  scene.add_planar_body(row, {0.03, 0.01}, 0.0);
  scene.add_planar_body(row, {0.03, 0.03}, 0.0);
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  scene.add_wall(segment_wall({-0.1, -0.1}, {-0.1, 0.1}, {}, rigid));
  Simulation simulation(scene);
  simulation.run_until(0.05);
  const auto contacts = simulation.contacts();
  ASSERT_EQ(contacts.size(), 6u);
  const Partners partners = count_partners(contacts);
  EXPECT_EQ(partners.body_pairs, 1);
  EXPECT_EQ(partners.wall_pairs, 1);
  EXPECT_DOUBLE_EQ(partners.per_body(2), 1.5);
  for (const ContactReport& contact : contacts) {
    EXPECT_NEAR(contact.point.z(), contact.with_wall ? 0.0 : 0.02, 1e-5);
  }
}

// Five balls in a zigzag between two walls, each in a strip of its own: what the strips carry is
// what the walls carry.
TEST(Strips, AddUpToTheForceOnTheWall) {
  Scene scene;
  scene.planar = true;
  const int material = scene.add_material({1e8, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, material, {.restitution = 0.3});
  scene.surfaces.set(material, rigid, {.restitution = 0.3});
  const int ball = scene.add_type(make_clump(chain_of_spheres(1, 0.01, 0.0), {.density = 1e3}));
  for (int i = 0; i < 5; ++i) {
    scene.add_planar_body(ball, {i % 2 == 0 ? 0.01 : 0.012, 0.01 + 0.0199 * i}, 0.0);
  }
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitX(), {}, rigid));
  scene.add_wall(plane_wall({0.022, 0.0, 0.0}, -Vec3::UnitX(), {}, rigid));
  Simulation simulation(scene, {.global_damping = 20.0});
  simulation.run_until(1.0);
  for (const int wall : {1, 2}) {
    const auto force =
        normal_force_by_strip(simulation.contacts(), wall, {.low = 0.0, .high = 0.1, .count = 5});
    double sum = 0.0;
    for (const double strip : force) sum += strip;
    EXPECT_GT(sum, 0.0);
    EXPECT_NEAR(sum / std::abs(simulation.wall_force(wall).x()), 1.0, 1e-6);
  }
  const auto left = normal_force_by_strip(simulation.contacts(), 1, {0.0, 0.1, 5});
  // Each contact between balls carries those above it: 4; 3 and 2; 1 weights push to the left
  EXPECT_NEAR(left[2] / left[0], 1.25, 5e-3);
  EXPECT_NEAR(left[0] / left[4], 4.0, 2e-2);
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

// Impossible physics is refused at the door with the reason.
TEST(Refusals, SayWhatIsWrong) {
  const auto with_material = [](double modulus, double poisson) {
    Scene scene = one_ball(0.0);
    scene.materials[0] = {modulus, poisson};
    return scene;
  };
  const auto with_surfaces = [](const Surfaces& surfaces) {
    Scene scene = one_ball(0.0);
    scene.surfaces.set(0, 1, surfaces);
    return scene;
  };
  const auto at_height = [](double z) {
    Scene scene = one_ball(0.0);
    scene.walls[0] = plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, 1);
    scene.bodies[0].position.z() = z;
    return scene;
  };
  struct Refusal {
    std::function<void()> act;
    const char* sentence;
  };
  const auto run = [](const Scene& scene, const SimulationOptions& options = {}) {
    Simulation simulation(scene, options);
  };
  const Refusal refusals[] = {
      {[&] { run(with_material(1e9, 0.5)); },
       "Material: poisson_ratio is 0.500000, must be above -1 and below 0.5"},
      {[&] { run(with_material(1e9, -1.0)); },
       "Material: poisson_ratio is -1.000000, must be above -1 and below 0.5"},
      {[&] { run(with_material(0.0, 0.3)); },
       "Material: youngs_modulus is 0.000000 Pa, must be above 0"},
      {[&] { run(with_surfaces({.restitution = 0.0})); },
       "Surfaces: restitution is 0.000000, must be above 0 and at most 1"},
      {[&] { run(with_surfaces({.restitution = 1.5})); },
       "Surfaces: restitution is 1.500000, must be above 0 and at most 1"},
      {[&] { run(with_surfaces({.friction = -0.1})); },
       "Surfaces: friction is -0.100000, must be finite and not below 0"},
      {[&] { run(with_surfaces({.friction = 0.3, .static_friction = 0.2})); },
       "Surfaces: static_friction is 0.200000, must be finite and not below friction, 0.300000, or "
       "0 "
       "for the same"},
      {[&] { run(with_surfaces({.rolling_friction = -0.1})); },
       "Surfaces: rolling_friction is -0.100000, must be finite and not below 0"},
      {[&] { run(at_height(0.0085)); },
       "Scene: body 0 overlaps wall 0 by 1.500000 mm at 0.000000 s, more than 0.100000 of a "
       "radius; "
       "bodies must start apart, such a contact would throw them off"},
      {[&] { run(at_height(-0.05)); },  // behind the wall
       "Scene: body 0 overlaps wall 0 by 60.000000 mm at 0.000000 s, more than 0.100000 of a "
       "radius; "
       "bodies must start apart, such a contact would throw them off"},
      {[&] { run(one_ball(0.0), {.time_step = {.fraction = 1.5}}); },
       "TimeStepOptions: fraction is 1.500000, must be above 0 and at most 1: a longer step than "
       "Rayleigh's is unstable"}};
  for (const Refusal& refusal : refusals) {
    std::string sentence;
    try {
      refusal.act();
    } catch (const std::invalid_argument& error) {
      sentence = error.what();
    }
    EXPECT_EQ(sentence, refusal.sentence);
  }
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
