#include "sim/engine/relaxation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

// Measured poses with noise: up to a millimetre and two degrees.
Scene disturbed_rig() {
  Scene scene = scenes::micro_rig();
  const auto part = [] { return *rc::gen::inRange(-1000, 1001) / 1000.0; };
  for (Body& body : scene.bodies) {
    body.position += 1e-3 * Vec3(part(), 0.0, part());
    body.picture_angle += 0.035 * part();
    body.orientation = orientation_from_picture_angle(body.picture_angle);
  }
  return scene;
}

RC_GTEST_PROP(RelaxOverlaps, LeavesOnlyStaticOverlaps, ()) {
  Scene scene = disturbed_rig();
  const Scene before = scene;
  const RelaxationSummary summary = relax_overlaps(scene);
  RC_ASSERT(summary.converged);
  RC_ASSERT(deepest_overlap(scene) <= 1e-6);  // static overlap of one body: 0.93 micrometre
  // Bodies that overlap by a few millimetres move by some of it, not across the rig
  RC_ASSERT(summary.largest_move < 6e-3);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    RC_ASSERT(scene.bodies[i].position.y() == 0.0);
    RC_ASSERT((scene.bodies[i].position - before.bodies[i].position).norm() <=
              summary.largest_move);
  }
  Scene again = before;
  relax_overlaps(again);
  RC_ASSERT(again.bodies[3].position == scene.bodies[3].position);
}

RC_GTEST_PROP(RelaxOverlaps, SettlingStartsGently, ()) {
  Scene scene = disturbed_rig();
  relax_overlaps(scene);
  Simulation simulation(scene, {.global_damping = 30.0});
  double fastest = 0.0;
  const auto look = [&](const State& state) {
    for (const Vec3& velocity : state.velocity) fastest = std::max(fastest, velocity.norm());
  };
  RC_ASSERT(simulation.run_until(0.15, {.interval = 1e-3, .observer = look}).status ==
            RunStatus::completed);
  // Nothing falls farther than a few millimetres: sqrt(2 g h) = 0.4 m/s for 8 mm. An overlap left
  // in would give metres.
  RC_ASSERT(fastest < 0.4);
}

TEST(RelaxOverlaps, LeavesAFreeSceneAlone) {
  Scene scene = scenes::micro_rig();
  relax_overlaps(scene);
  const Scene before = scene;
  const RelaxationSummary summary = relax_overlaps(scene);
  EXPECT_EQ(summary.sweeps, 0);
  EXPECT_EQ(summary.largest_move, 0.0);
  EXPECT_EQ(scene.bodies[0].position, before.bodies[0].position);
}

TEST(RelaxOverlaps, TwoBallsPartEvenly) {
  Scene scene;
  scene.add_material({1e9, 0.3});
  const int ball = scene.add_type(make_clump(chain_of_spheres(1, 0.01, 0.0), {.mass = 0.01}));
  scene.add_body(ball, {0.0, 0.0, 0.0});
  scene.add_body(ball, {0.0, 0.019, 0.0});
  const RelaxationSummary summary = relax_overlaps(scene);
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(scene.bodies[0].position.y(), -0.0005, 1e-6);
  EXPECT_NEAR(scene.bodies[1].position.y(), 0.0195, 1e-6);
}

TEST(RelaxOverlaps, SaysWhenThereIsNoRoom) {
  Scene scene;
  scene.planar = true;
  scene.add_material({1e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  const int ball = scene.add_type(make_clump(chain_of_spheres(1, 0.01, 0.0), {.mass = 0.01}));
  scene.add_planar_body(ball, {0.0, 0.0}, 0.0);
  scene.add_wall(plane_wall({-0.009, 0.0, 0.0}, Vec3::UnitX(), {}, rigid));
  scene.add_wall(plane_wall({0.009, 0.0, 0.0}, -Vec3::UnitX(), {}, rigid));
  EXPECT_FALSE(relax_overlaps(scene, {.largest_sweep_count = 50}).converged);
}

}  // namespace
}  // namespace graintruth::sim
