// Planar turning; free bodies are compared with closed forms in cases/rotation_cases.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/simulation.h"

namespace graintruth::sim {
namespace {

TEST(PlanarSpin, PictureAngleGrowsFromXTowardsZ) {
  Scene scene;
  scene.planar = true;
  scene.gravity.setZero();
  scene.add_material({1e9, 0.3});
  const int type = scene.add_type(make_clump(chain_of_spheres(2, 0.01, 0.01), {.mass = 0.1}));
  scene.add_planar_body(type, {0.0, 0.0}, 7.0, {0.0, 0.0}, 3.0);
  Simulation simulation(scene);
  simulation.run_until(1.0);
  const State& state = simulation.state();
  EXPECT_NEAR(state.picture_angle[0], 10.0, 1e-10);  // unwrapped
  const Vec3 axis = state.orientation[0] * Vec3::UnitX();
  EXPECT_NEAR(axis.x(), std::cos(10.0), 1e-9);
  EXPECT_NEAR(axis.z(), std::sin(10.0), 1e-9);
  EXPECT_NEAR(state.angular_velocity[0].y(), -3.0, 1e-12);  // right-handed, y away from the viewer
  EXPECT_NEAR(picture_angle_of(orientation_from_picture_angle(2.5)), 2.5, 1e-15);
}

}  // namespace
}  // namespace graintruth::sim
