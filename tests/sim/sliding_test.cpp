// Friction: sliding, sticking and rolling on an incline and on the flat.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/simulation.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::read_rows;
using tests::Row;

constexpr double kGravity = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;

// A row of touching balls flat on a plane whose gravity is tilted by `incline`, started at its
// static overlap.
Scene on_incline(int spheres, double radius, double incline, double friction, bool planar) {
  Scene scene;
  scene.planar = planar;
  scene.gravity = kGravity * Vec3(std::sin(incline), 0.0, -std::cos(incline));
  const int material = scene.add_material({3.5e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = friction, .restitution = 0.5});
  const int type = scene.add_type(
      make_clump(chain_of_spheres(spheres, radius, 2.0 * radius), {.density = 1256.4}));
  const double modulus =
      mix(scene.materials[0], scene.materials[1], {}, Tension::allowed, 0.0).normal_modulus;
  const double k = 4.0 / 3.0 * modulus * std::sqrt(radius);
  const double overlap =
      std::pow(-scene.types[type].mass * scene.gravity.z() / (spheres * k), 2.0 / 3.0);
  scene.add_body(type, {0.0, 0.0, radius - overlap});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  return scene;
}

TEST(SlidingBlock, AccelerationAt30DegreesIsCoulombs) {
  const double incline = 30.0 * kDegree;
  for (const bool planar : {true, false}) {
    for (const double mu : {0.1, 0.2, 0.3, 0.4, 0.5}) {
      for (const double tangential_damping : {0.0, 1.0}) {
        Simulation simulation(
            on_incline(5, 0.01, incline, mu, planar),
            {.time_step = {.fraction = 1.0}, .tangential_damping = tangential_damping});
        // The springs must stretch before they slide, which leaves a speed of its own: compare two
        // later moments
        simulation.run_until(0.1);
        const double early = simulation.state().velocity[0].x();
        simulation.run_until(0.3);
        const double acceleration = (simulation.state().velocity[0].x() - early) / 0.2;
        const double exact = kGravity * (std::sin(incline) - mu * std::cos(incline));
        // 0.1 % (specification 6)
        EXPECT_NEAR(acceleration / exact, 1.0, 1e-3) << "mu " << mu;
      }
    }
  }
}

TEST(SlidingBlock, SticksWhenFrictionHolds) {
  for (const double mu : {0.58, 0.7}) {
    Simulation simulation(on_incline(5, 0.01, 30.0 * kDegree, mu, true), {});
    // Gravity sets in at once, so the springs overshoot and may slip a little at first; afterwards
    // nothing creeps
    simulation.run_until(0.1);
    const double early = simulation.state().position[0].x();
    EXPECT_LT(std::abs(early), 1e-5);
    simulation.run_until(0.2);
    EXPECT_LT(std::abs(simulation.state().position[0].x() - early), 1e-10);
    EXPECT_LT(simulation.state().velocity[0].norm(), 1e-8);
  }
}

TEST(RollingSphere, Incline) {
  for (const Row& row : read_rows(bundled_reference("rolling_sliding/incline_sphere.csv"))) {
    const double incline = number(row, "incline_deg") * kDegree, mu = number(row, "mu");
    SCOPED_TRACE(row.at("incline_deg") + " degrees, mu " + row.at("mu"));
    const double radius = 0.01, time = 0.2;
    Simulation simulation(on_incline(1, radius, incline, mu, false),
                          {.time_step = {.fraction = 1.0}});
    simulation.run_until(time);
    const State& state = simulation.state();
    EXPECT_NEAR(state.velocity[0].x() / (time * number(row, "acceleration_m_s2")), 1.0, 5e-3);
    EXPECT_NEAR(radius * state.angular_velocity[0].y() / (time * number(row, "R_times_alpha_m_s2")),
                1.0,
                5e-3);
  }
}

TEST(RollingSphere, SlidesIntoRolling) {
  for (const Row& row : read_rows(bundled_reference("rolling_sliding/slide_to_roll_sphere.csv"))) {
    const double radius = number(row, "R_m"), mu = number(row, "mu"), v0 = number(row, "v0_m_s");
    const double exact_time = number(row, "t_roll_s");
    SCOPED_TRACE(row.at("R_m"));
    Scene scene = on_incline(1, radius, 0.0, mu, true);
    scene.bodies[0].velocity.x() = v0;
    Simulation simulation(scene, {.time_step = {.fraction = 1.0}});
    double rolls_at = 0.0;
    const auto look = [&](const State& state) {
      const double slip = state.velocity[0].x() - radius * state.angular_velocity[0].y();
      if (rolls_at == 0.0 && slip <= 1e-3 * v0) rolls_at = state.time;
    };
    simulation.run_until(1.2 * exact_time, {.interval = 1e-3 * exact_time, .observer = look});
    const State& state = simulation.state();
    EXPECT_NEAR(rolls_at / exact_time, 1.0, 1e-2);
    EXPECT_NEAR(state.velocity[0].x() / number(row, "v_roll_m_s"), 1.0, 2e-3);
    EXPECT_NEAR(state.angular_velocity[0].y() / number(row, "omega_roll_rad_s"), 1.0, 2e-3);
    // 20 % longer than the transition, at the rolling speed
    const double distance =
        number(row, "distance_m") + 0.2 * exact_time * number(row, "v_roll_m_s");
    EXPECT_NEAR(state.position[0].x() / distance, 1.0, 5e-3);
  }
}

}  // namespace
}  // namespace graintruth::sim
