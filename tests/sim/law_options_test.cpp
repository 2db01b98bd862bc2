// The contact laws that may be chosen instead of the default one.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "sim/engine/contact_kernel.h"
#include "sim/laws/restitution.h"
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

// Overlap, m, of one ball of the weight of chapter 3 that has come to rest on a rigid plane.
double overlap_at_rest(const SimulationOptions& options) {
  Scene scene = ball_over_plane(0.5, 0.0);
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  scene.types[0] = make_clump(chain_of_spheres(1, kRadius, 0.0), {.mass = 0.2105 / kGravity});
  Simulation simulation(scene, options);
  simulation.run_until(0.1);
  EXPECT_NEAR(-simulation.wall_force(0).z() / 0.2105, 1.0, 1e-6);
  return simulation.contacts().at(0).overlap;
}

// Tables 3.1-3.3: W = (4/3) E* sqrt(R) d^1.5 gives 5.523e-7 m. The total force finds it at any
// step; the force that is added up from step to step finds the weight, but not the overlap.
TEST(IncrementalForce, LosesTheOverlapWhichTheTotalForceKeeps) {
  for (const double fraction : {0.3, 0.1}) {
    EXPECT_NEAR(overlap_at_rest({.time_step = {.fraction = fraction}}) / 5.523e-7, 1.0, 1e-3);
    const double drifted = overlap_at_rest(
        {.time_step = {.fraction = fraction}, .normal_spring = NormalSpring::incremental});
    EXPECT_GT(std::abs(drifted / 5.523e-7 - 1.0), 0.02) << drifted;
  }
}

// F = k_n d, k_n = 2 E* sqrt(R* d): 1.5 times Hertz's force.
TEST(SecantSpring, IsOneAndAHalfTimesAsStiffAndReboundsAsAsked) {
  const double overlap = overlap_at_rest({.normal_spring = NormalSpring::secant});
  EXPECT_NEAR(overlap / (5.523e-7 * std::pow(1.5, -2.0 / 3.0)), 1.0, 1e-3);
  for (const Tension tension : {Tension::clipped, Tension::allowed}) {
    for (const double e : {0.3, 0.7, 1.0}) {
      Simulation simulation(ball_over_plane(e, 0.1),
                            {.time_step = {.fraction = 0.05},
                             .normal_spring = NormalSpring::secant,
                             .tension = tension});
      const double before = simulation.energy().total();
      simulation.run_until(0.00005);
      if (e == 1.0) {
        EXPECT_NEAR(simulation.energy().total() / before, 1.0, 1e-3);
        EXPECT_GT(simulation.energy().elastic, 0.1 * before);
      }
      simulation.run_until(0.003);
      EXPECT_NEAR(simulation.state().velocity[0].z() / 0.1, e, 2e-3);
    }
  }
}

// A ball is sheared under little pressure, pressed, sheared back and let go: a closed cycle. What
// the tangential force gives away over it, in units of what its spring stored at first.
double work_of_cycle(TangentialSpring tangential) {
  const Material material{1e7, 0.3};
  const PairTable pairs = {mix(material, material, {.friction = 100.0}, Tension::clipped, 0.0)};
  const ChosenLaw law{.tangential_spring = tangential};
  auto batch = std::make_unique<ContactBatch<2>>();
  batch->count = 1;
  batch->pair[0] = 0;
  batch->normal.set(0, {1.0, 0.0});
  batch->radius.set(0, kRadius);
  batch->inverse_mass.set(0, 1.0);
  batch->contact_count.set(0, 1.0);
  batch->reduced_radius.set(0, 0.5 * kRadius);
  batch->slip_time = 1.0;
  double work = 0.0;
  const auto go = [&](double from, double to, double slip) {
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
      const double overlap = from + (to - from) * (i + 0.5) / kSteps;
      batch->overlap.set(0, overlap);
      batch->stiffness.set(0, hertz_stiffness(pairs[0], 0.5 * kRadius, overlap));
      batch->sum_of_stiffness.set(0, batch->stiffness.at(0));
      batch->second.velocity.set(0, {0.0, slip / kSteps});
      apply_law(law, pairs, *batch);
      batch->was_touching[0] = kTouching;
      batch->spring_before = batch->spring;
      work += batch->tangential_force.at(0) * slip / kSteps;
    }
  };
  batch->was_touching[0] = kOpen;
  go(1e-6, 1e-6, 1e-7);
  const double stored = -work;
  go(1e-6, 9e-6, 0.0);
  go(9e-6, 9e-6, -1e-7);
  go(9e-6, 1e-6, 0.0);
  return work / stored;
}

TEST(ScaledMindlinSpring, MakesNoEnergyInACycle) {
  // Nine times the overlap is three times the stiffness k; sheared by s under k, back under 3 k:
  // -k s^2/2 + 3 k s^2/2
  EXPECT_NEAR(work_of_cycle(TangentialSpring::mindlin), 2.0, 1e-2);
  // -k s^2/2 - 3 k [(2 s/3)^2 - (s/3)^2]/2
  EXPECT_NEAR(work_of_cycle(TangentialSpring::mindlin_scaled), -2.0, 1e-2);
}

// Every form of the law slides by Coulomb: a = g (sin - mu cos).
TEST(Sliding, IsCoulombsForEveryForm) {
  const double incline = std::numbers::pi / 6.0, mu = 0.3;
  const double exact = kGravity * (std::sin(incline) - mu * std::cos(incline));
  const SimulationOptions forms[] = {
      {.tangential_spring = TangentialSpring::constant, .tangential_stiffness = 1e6},
      {.tangential_spring = TangentialSpring::mindlin_scaled},
      {.normal_spring = NormalSpring::secant},
      {.normal_spring = NormalSpring::incremental},
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

// Turning about the normal is not rolling: a spinning ball is only held by its sliding friction,
// which has no lever at the pole.
TEST(RollingFriction, LeavesASpinAboutTheNormalAlone) {
  Scene scene =
      cases::on_incline(1, kRadius, 0.0, {.friction = 0.5, .rolling_friction = 0.1}, false);
  scene.bodies[0].angular_velocity = Vec3(0.0, 0.0, 10.0);
  Simulation simulation(scene);
  simulation.run_until(0.05);
  EXPECT_NEAR(simulation.state().angular_velocity[0].z(), 10.0, 1e-9);
}

// Two balls pressed together that turn against each other: the moment is mu_r R* N on both.
TEST(RollingFriction, IsEqualAndOppositeOnBoth) {
  for (const bool planar : {true, false}) {
    Scene scene = cases::on_incline(1, kRadius, 0.0, {}, planar);
    scene.gravity.setZero();
    scene.surfaces.set(0, 0, {.friction = 0.5, .restitution = 1.0, .rolling_friction = 0.2});
    scene.walls.clear();
    scene.bodies[0].position = Vec3(-kRadius + 1e-6, 0.0, 0.0);
    scene.bodies[0].angular_velocity.y() = 500.0;
    Body other = scene.bodies[0];
    other.position = Vec3(kRadius - 1e-6, 0.0, 0.0);
    other.angular_velocity.y() = -500.0;
    scene.bodies.push_back(other);
    Simulation simulation(scene, {.time_step = {.fraction = 0.02}});
    simulation.run_until(0.001);
    const State& state = simulation.state();
    EXPECT_LT(state.angular_velocity[0].y(), 500.0 - 1e-2);
    EXPECT_NEAR(state.angular_velocity[0].y() + state.angular_velocity[1].y(), 0.0, 1e-10);
    // The impulse of the normal force is m dv, so that of the moment is mu_r R* m dv
    const double impulse = scene.types[0].mass * state.velocity[1].x();
    EXPECT_NEAR(scene.types[0].inertia.y() * (500.0 - state.angular_velocity[0].y()) /
                    (0.2 * 0.5 * kRadius * impulse),
                1.0,
                1e-2);
  }
}

TEST(RollingFriction, BelowZeroIsRefused) {
  EXPECT_THROW(check(Surfaces{.rolling_friction = -0.1}), std::invalid_argument);
}

TEST(StaticFriction, BelowTheDynamicOneIsRefused) {
  EXPECT_THROW(check(Surfaces{.friction = 0.3, .static_friction = 0.2}), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
