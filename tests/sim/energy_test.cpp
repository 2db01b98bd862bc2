// Momentum and energy of colliding clumps.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/motion.h"
#include "sim/simulation.h"

namespace graintruth::sim {
namespace {

// Clumps of three balls thrown at each other from a lattice, without gravity or walls.
Scene cloud(bool planar, const Surfaces& surfaces, unsigned seed) {
  Scene scene;
  scene.planar = planar;
  scene.gravity.setZero();
  const int material = scene.add_material({1e8, 0.3});
  scene.surfaces.set(material, material, surfaces);
  const int type =
      scene.add_type(make_clump(chain_of_spheres(3, 0.01, 0.012), {.density = 1500.0}));
  std::mt19937 random(seed);
  const auto part = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 place(0.06 * (i - 1.5), 0.0, 0.06 * (k - 1.0));
      if (planar) {
        const Vec2 velocity = -5.0 * into_plane(place) + 0.3 * Vec2(part(), part());
        scene.add_planar_body(type, into_plane(place), 3.0 * part(), velocity, 5.0 * part());
      } else {
        const Vec3 velocity = -5.0 * place + 0.3 * Vec3(part(), part(), part());
        const Quat orientation = Quat(part(), part(), part(), part()).normalized();
        scene.add_body(type, place, orientation, velocity, 5.0 * Vec3(part(), part(), part()));
      }
    }
  }
  return scene;
}

Vec3 linear_momentum(const Scene& scene, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i)
    sum += scene.types[0].mass * state.velocity[i];
  return sum;
}

Vec3 angular_momentum(const Scene& scene, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i) {
    const Vec3 spin = state.orientation[i].conjugate() * state.angular_velocity[i];
    sum += scene.types[0].mass * state.position[i].cross(state.velocity[i]) +
           state.orientation[i] * scene.types[0].inertia.cwiseProduct(spin);
  }
  return sum;
}

TEST(Momentum, IsKeptInCollisions) {
  for (const bool planar : {true, false}) {
    const Scene scene = cloud(planar, {.friction = 0.3, .restitution = 0.7}, 1);
    Simulation simulation(scene, {.time_step = {.fraction = 0.2}});
    const Vec3 linear = linear_momentum(scene, simulation.state());
    const Vec3 angular = angular_momentum(scene, simulation.state());
    const double linear_scale = 12 * scene.types[0].mass * 0.5;
    double contacts = simulation.run_until(0.2).mean_contacts;
    ASSERT_GT(contacts, 0.01);
    EXPECT_LT((linear_momentum(scene, simulation.state()) - linear).norm(), 1e-12 * linear_scale);
    EXPECT_LT((angular_momentum(scene, simulation.state()) - angular).norm(),
              1e-7 * linear_scale * 0.1);
  }
}

TEST(Energy, ElasticFrictionlessCollisionsKeepIt) {
  for (const bool planar : {true, false}) {
    Simulation simulation(cloud(planar, {}, 2), {.time_step = {.fraction = 0.1}});
    const double before = simulation.energy().total();
    simulation.run_until(0.2);
    EXPECT_NEAR(simulation.energy().total() / before, 1.0, 1e-4);  // the bar of our validation plan
  }
}

TEST(Energy, LossesAccountForWhatIsGone) {
  for (const bool planar : {true, false}) {
    Simulation simulation(cloud(planar, {.friction = 0.3, .restitution = 0.6}, 3),
                          {.time_step = {.fraction = 0.1}, .tally_work = true});
    const double before = simulation.energy().total();
    simulation.run_until(0.2);
    const Energy after = simulation.energy();
    const double lost = before - after.total();
    ASSERT_GT(lost, 0.05 * before);
    EXPECT_NEAR((after.damping_loss + after.friction_loss) / lost, 1.0, 1e-2);
    EXPECT_GT(after.damping_loss, 0.0);
    EXPECT_GT(after.friction_loss, 0.0);
  }
}

}  // namespace
}  // namespace graintruth::sim
