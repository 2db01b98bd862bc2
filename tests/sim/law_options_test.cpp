// The contact laws that may be chosen instead of the default one.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/restitution.h"
#include "sim/simulation.h"
#include "tests/sim/cases/incline.h"

namespace graintruth::sim {
namespace {

using cases::kGravity;

constexpr double kRadius = 0.01;

// One ball just above a rigid plane, without weight.
Scene ball_over_plane(double restitution, double speed) {
  Scene scene;
  scene.gravity.setZero();
  const int material = scene.add_material({3.5e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = 0.0, .restitution = restitution});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(1, kRadius, 0.0), {.density = 1256.4}));
  scene.add_body(type, {0.0, 0.0, kRadius}, Quat::Identity(), {0.0, 0.0, -speed});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  return scene;
}

TEST(LinearSpring, ReboundsAsAsked) {
  for (const Tension tension : {Tension::clipped, Tension::allowed}) {
    for (const double e : {0.3, 0.5, 0.8, 1.0}) {
      Simulation simulation(ball_over_plane(e, 0.1),
                            {.time_step = {.steps_per_contact = 400.0},
                             .normal_spring = NormalSpring::linear,
                             .linear_stiffness = 1e5,
                             .tension = tension});
      simulation.run_until(0.01);
      EXPECT_NEAR(simulation.state().velocity[0].z() / 0.1, e, 5e-3) << "e " << e;
    }
  }
}

// Half a period of m z'' = -k z:  pi sqrt(m/k), whatever the speed.
TEST(LinearSpring, ContactLastsHalfAPeriod) {
  for (const double speed : {0.01, 0.1}) {
    const Scene scene = ball_over_plane(1.0, speed);
    const double exact = std::numbers::pi * std::sqrt(scene.types[0].mass / 1e5);
    Simulation simulation(scene,
                          {.time_step = {.steps_per_contact = 1000.0},
                           .normal_spring = NormalSpring::linear,
                           .linear_stiffness = 1e5});
    simulation.run_until(0.99 * exact);
    EXPECT_EQ(simulation.contacts().size(), 1u);
    simulation.run_until(1.01 * exact);
    EXPECT_EQ(simulation.contacts().size(), 0u);
  }
}

TEST(LinearSpring, NeedsAStiffness) {
  EXPECT_THROW(Simulation(ball_over_plane(1.0, 0.1), {.normal_spring = NormalSpring::linear}),
               std::invalid_argument);
  EXPECT_THROW(Simulation(ball_over_plane(1.0, 0.1), {.linear_stiffness = 1e5}),
               std::invalid_argument);
}

// beta grows by sqrt(6/5): exp(-pi b/sqrt(1 - b^2)) is 0.837, 0.698, 0.477 for 0.85, 0.72, 0.51.
TEST(ThesisDamping, ReboundsLessThanAsked) {
  const double asked[] = {0.85, 0.72, 0.51}, gets[] = {0.837, 0.698, 0.477};
  for (int i = 0; i < 3; ++i) {
    Simulation simulation(ball_over_plane(asked[i], 0.1),
                          {.time_step = {.fraction = 0.02},
                           .damping_form = DampingForm::thesis,
                           .tension = Tension::allowed});
    simulation.run_until(0.003);
    EXPECT_NEAR(simulation.state().velocity[0].z() / 0.1, gets[i], 2e-3) << asked[i];
  }
}

// Five balls flat on a plane whose gravity is tilted.
Scene on_incline(double incline, const Surfaces& surfaces) {
  return cases::on_incline(5, kRadius, incline, surfaces, true);
}

double acceleration_of(Simulation& simulation) {
  simulation.run_until(0.1);
  const double early = simulation.state().velocity[0].x();
  simulation.run_until(0.2);
  return (simulation.state().velocity[0].x() - early) / 0.1;
}

// Every form of the law slides by Coulomb: a = g (sin - mu cos).
TEST(Sliding, IsCoulombsForEveryForm) {
  const double incline = std::numbers::pi / 6.0, mu = 0.3;
  const double exact = kGravity * (std::sin(incline) - mu * std::cos(incline));
  const SimulationOptions forms[] = {
      {.tangential_spring = TangentialSpring::constant, .tangential_stiffness = 1e6},
      {.coulomb_limit = CoulombLimit::spring, .tangential_damping = 0.0},
      {.tension = Tension::allowed},
      {.damping_sharing = DampingSharing::none}};
  for (const SimulationOptions& form : forms) {
    Simulation simulation(on_incline(incline, {.friction = mu, .restitution = 0.5}), form);
    EXPECT_NEAR(acceleration_of(simulation) / exact, 1.0, 1e-3);
  }
}

// Static and dynamic friction of the thesis's buttons. At 18 degrees they hold, although gravity
// sets in at once and the springs overshoot; they slide on once they have been pushed.
TEST(StaticFriction, HoldsUntilItSlips) {
  const Surfaces buttons{.friction = 0.2, .restitution = 0.5, .static_friction = 0.61};
  const double incline = 0.1 * std::numbers::pi;  // tan = 0.325
  Simulation resting(on_incline(incline, buttons), {});
  resting.run_until(0.2);
  EXPECT_LT(resting.state().position[0].x(), 1e-5);

  Scene pushed = on_incline(incline, buttons);
  pushed.bodies[0].velocity.x() = 0.05;
  Simulation sliding(pushed, {});
  const double exact = kGravity * (std::sin(incline) - 0.2 * std::cos(incline));
  EXPECT_NEAR(acceleration_of(sliding) / exact, 1.0, 1e-3);
}

TEST(StaticFriction, StopsAndHoldsAgain) {
  const Surfaces surfaces{.friction = 0.2, .restitution = 0.5, .static_friction = 0.61};
  // Slides on the flat, stops after v/(mu g) and v^2/(2 mu g)
  Scene scene = on_incline(0.0, surfaces);
  scene.bodies[0].velocity.x() = 0.2;
  Simulation simulation(scene, {});
  simulation.run_until(0.2);
  EXPECT_NEAR(simulation.state().position[0].x() / (0.04 / (2.0 * 0.2 * kGravity)), 1.0, 1e-2);
  EXPECT_LT(std::abs(simulation.state().velocity[0].x()), 1e-4);
}

TEST(StaticFriction, BelowTheDynamicOneIsRefused) {
  EXPECT_THROW(check(Surfaces{.friction = 0.3, .static_friction = 0.2}), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
