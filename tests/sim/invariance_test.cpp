// The same physics seen from elsewhere: turned, mirrored, renumbered, in space instead of the
// layer.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

// Half a second of the rig is chaotic; the first hundredths are not, and have every kind of contact
// in them.
constexpr double kTime = 0.03;
constexpr double kClose = 1e-10;  // m; round-off of 1e-17 m grown through some twenty contacts

Scene relaxed_rig() {
  Scene scene = scenes::micro_rig(0.2, 0.7);
  relax_overlaps(scene);
  return scene;
}

State run(const Scene& scene) {
  Simulation simulation(scene);
  EXPECT_EQ(simulation.run_until(kTime).status, RunStatus::completed);
  return simulation.state();
}

TEST(Invariance, PlanarIsSpatialOfAPlanarScene) {
  Scene scene = relaxed_rig();
  const State planar = run(scene);
  scene.planar = false;
  const State spatial = run(scene);
  for (std::size_t i = 0; i < planar.position.size(); ++i) {
    EXPECT_LT((planar.position[i] - spatial.position[i]).norm(), kClose);
    EXPECT_LT(planar.orientation[i].angularDistance(spatial.orientation[i]), 1e-7);
    EXPECT_LT((planar.velocity[i] - spatial.velocity[i]).norm(), 1e-7);
  }
}

RC_GTEST_PROP(Invariance, SceneTurnedInThePicture, ()) {
  const double angle = *rc::gen::inRange(-314, 314) / 100.0;
  const Eigen::Rotation2Dd turn(angle);
  const auto turned = [&](const Vec3& v) {
    const Vec2 in_picture = turn * Vec2(v.x(), v.z());
    return Vec3(in_picture.x(), v.y(), in_picture.y());
  };
  const Scene scene = relaxed_rig();
  Scene other = scene;
  other.gravity = turned(scene.gravity);
  for (Wall& wall : other.walls) {
    wall.from = turn * wall.from;
    wall.to = turn * wall.to;
    wall.motion.velocity = turned(wall.motion.velocity);
  }
  for (Body& body : other.bodies) {
    body.position = turned(body.position);
    body.picture_angle += angle;
    body.orientation = orientation_from_picture_angle(body.picture_angle);
  }
  const State a = run(scene), b = run(other);
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    RC_ASSERT((turned(a.position[i]) - b.position[i]).norm() < kClose);
    RC_ASSERT(std::abs(a.picture_angle[i] + angle - b.picture_angle[i]) < 1e-7);
  }
}

TEST(Invariance, Mirrored) {
  const Scene scene = relaxed_rig();
  Scene mirrored = scene;
  for (Wall& wall : mirrored.walls) {
    wall.from.x() = -wall.from.x();
    wall.to.x() = -wall.to.x();
  }
  for (Body& body : mirrored.bodies) {
    body.position.x() = -body.position.x();
    body.picture_angle = -body.picture_angle;
    body.orientation = orientation_from_picture_angle(body.picture_angle);
  }
  const State a = run(scene), b = run(mirrored);
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    EXPECT_LT((Vec3(-a.position[i].x(), 0.0, a.position[i].z()) - b.position[i]).norm(), kClose);
    EXPECT_NEAR(a.picture_angle[i], -b.picture_angle[i], 1e-7);
  }
}

RC_GTEST_PROP(Invariance, Renumbered, ()) {
  const Scene scene = relaxed_rig();
  std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    std::swap(order[i], order[*rc::gen::inRange<std::size_t>(0, i + 1)]);
  }
  Scene other = scene;
  for (std::size_t i = 0; i < order.size(); ++i) other.bodies[i] = scene.bodies[order[i]];
  std::reverse(other.walls.begin(), other.walls.end());
  const State a = run(scene), b = run(other);
  for (std::size_t i = 0; i < order.size(); ++i) {
    RC_ASSERT((a.position[order[i]] - b.position[i]).norm() < kClose);
  }
}

// Lengths x 2, densities the same, gravity x 1/2 and stiffness kept: with t x 2 every length
// doubles. (Froude and Cauchy numbers both kept: v ~ 1, g ~ v^2/L, E ~ rho v^2.)
TEST(Invariance, ScaledScene) {
  Scene scene = relaxed_rig();
  for (Wall& wall : scene.walls) wall.motion.velocity.setZero();
  Scene large = scene;
  large.gravity *= 0.5;
  large.types[0] =
      make_clump(chain_of_spheres(2, 2.0 * 0.022225, 2.0 * 0.02783), {.mass = 8.0 * 0.142});
  for (Wall& wall : large.walls) {
    wall.from *= 2.0;
    wall.to *= 2.0;
  }
  for (Body& body : large.bodies) body.position *= 2.0;
  Simulation small_run(scene), large_run(large);
  small_run.run_until(kTime, {.interval = 1e-5});
  large_run.run_until(2.0 * kTime, {.interval = 2e-5});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    EXPECT_LT((2.0 * small_run.state().position[i] - large_run.state().position[i]).norm(), kClose);
  }
}

}  // namespace
}  // namespace graintruth::sim
