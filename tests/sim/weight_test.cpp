// Bodies at rest: the wall carries their weight, at the overlap of Hertz.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/simulation.h"

namespace graintruth::sim {
namespace {

// `count` touching balls of 1 cm with a given weight flat on a rigid plane, dropped from just above
// it.
Simulation resting(int count, double weight, bool planar) {
  Scene scene;
  scene.planar = planar;
  const int material = scene.add_material({3.5e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = 0.2, .restitution = 0.3});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(count, 0.01, 0.02), {.mass = weight / 9.81}));
  scene.add_body(type, {0.0, 0.0, 0.01});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  Simulation simulation(scene, {.time_step = {.fraction = 0.3}});
  simulation.run_until(0.05);
  return simulation;
}

TEST(Weight, WallCarriesItForAnyNumberOfContacts) {
  constexpr double kWeight = 0.2105;
  for (const bool planar : {true, false}) {
    for (int count = 1; count <= 9; ++count) {
      const Simulation simulation = resting(count, kWeight, planar);
      EXPECT_EQ(static_cast<int>(simulation.contacts().size()), count);
      EXPECT_NEAR(-simulation.wall_force(0).z() / kWeight, 1.0, 1e-6) << count << " contacts";
    }
  }
}

// Errata item 31: 5.523e-7 m with one contact, 3.479e-7 m with two (digits as stated).
TEST(Weight, OverlapIsTheStaticOneOfHertz) {
  EXPECT_NEAR(resting(1, 0.2105, false).contacts()[0].overlap, 5.523e-7, 5e-11);
  EXPECT_NEAR(resting(2, 0.2105, false).contacts()[0].overlap, 3.479e-7, 5e-11);
}

}  // namespace
}  // namespace graintruth::sim
