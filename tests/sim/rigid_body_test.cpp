// Free bodies: falling, turning, and one push.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/integrate.h"
#include "sim/simulation.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::outside_reference;
using tests::read_rows;
using tests::Row;

TEST(FreeFall, FollowsTheParabola) {
  for (const bool planar : {true, false}) {
    Scene scene;
    scene.planar = planar;
    scene.add_material({1e9, 0.3});
    const int type =
        scene.add_type(make_clump(chain_of_spheres(2, 0.01, 0.01), {.density = 2000.0}));
    scene.add_body(type, Vec3::Zero(), Quat::Identity(), {1.0, 0.0, 2.0});
    Simulation simulation(scene);
    simulation.run_until(0.04);
    // Exact for a leapfrog with v(-1/2) = v0 - g dt/2, up to the round-off of a few thousand
    // additions
    EXPECT_NEAR(simulation.state().position[0].z(), 2.0 * 0.04 - 0.5 * 9.81 * 0.0016, 1e-13);
    EXPECT_NEAR(simulation.state().velocity[0].z(), 2.0 - 9.81 * 0.04, 1e-12);
    EXPECT_NEAR(simulation.state().position[0].x(), 0.04, 1e-13);
  }
}

// Thesis 3.7-3.10: 1000 N for one step of 8.61e-6 s at a lever of 1.5 cm.
TEST(OnePush, GivesTheSpeedsOfTheThesis) {
  Scene scene;
  scene.planar = true;
  scene.add_material({1e9, 0.3});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(9, 0.008248, 0.012087),
                                {.mass = 0.0243, .inertia = Vec3::Constant(2.433e-5)}));
  scene.add_planar_body(type, Vec2::Zero(), 0.0);
  Bodies<2> bodies = make_bodies<2>(scene);
  const StepFactors step = step_factors(8.61e-6, 0.0);
  const PlanarVector push{0.0, 1000.0};
  bodies.load[0] = {push, moment(PlanarVector{0.015, 0.0}, push)};
  find_accelerations(Vec2::Zero(), step, {}, bodies);
  advance(step, bodies);
  EXPECT_NEAR(bodies.motion[0].velocity.z / (1000.0 * 8.61e-6 / 0.0243), 1.0, 1e-9);
  EXPECT_NEAR(bodies.motion[0].spin / (15.0 * 8.61e-6 / 2.433e-5), 1.0, 1e-9);
  EXPECT_NEAR(bodies.motion[0].velocity.z, 0.354321, 5e-7);
  EXPECT_NEAR(bodies.motion[0].spin, 5.30826, 5e-6);
}

Scene free_body(const Vec3& inertia, const Vec3& spin) {
  Scene scene;
  scene.gravity.setZero();
  scene.add_material({1e6, 0.3});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(1, 1.0, 0.0), {.mass = 1.0, .inertia = inertia}));
  scene.add_body(type, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), spin);
  return scene;
}

struct Turning {
  double largest_error = 0.0;   // rad/s; of omega in body axes
  double momentum_drift = 0.0;  // relative, of the vector in space
  double energy_drift = 0.0;    // relative
};

// The two files name their columns differently.
Vec3 omega_of(const Row& row) {
  if (row.contains("w1")) return {number(row, "w1"), number(row, "w2"), number(row, "w3")};
  return {number(row, "omega_x"), number(row, "omega_y"), number(row, "omega_z")};
}

Turning follow(const std::vector<Row>& rows, const Vec3& inertia, double time_step, int axes) {
  const Vec3 start = omega_of(rows[0]);
  Simulation simulation(
      free_body(inertia, start),
      {.time_step = {.fraction = 1.0, .largest = time_step}, .largest_move = 1e3});
  Turning result;
  const Vec3 momentum = inertia.cwiseProduct(start);
  const double energy = 0.5 * start.dot(momentum);
  for (const Row& row : rows) {
    simulation.run_until(number(row, "t_s"));
    const State& state = simulation.state();
    const Vec3 omega = state.orientation[0].conjugate() * state.angular_velocity[0];
    const Vec3 exact = omega_of(row);
    result.largest_error =
        std::max(result.largest_error, (omega - exact).head(axes).cwiseAbs().maxCoeff());
    const Vec3 now = state.orientation[0] * inertia.cwiseProduct(omega);
    result.momentum_drift =
        std::max(result.momentum_drift, std::abs(now.norm() / momentum.norm() - 1.0));
    result.energy_drift = std::max(
        result.energy_drift, std::abs(0.5 * omega.dot(inertia.cwiseProduct(omega)) / energy - 1.0));
  }
  return result;
}

TEST(TorqueFreeRotation, SymmetricBody) {
  const auto rows = read_rows(bundled_reference("torque_free_rotation/omega_exact.csv"));
  ASSERT_GT(rows.size(), 10u);
  const Vec3 inertia(0.25, 0.25, 0.125);
  const Turning fine = follow(rows, inertia, 1e-4, 2), coarse = follow(rows, inertia, 2e-4, 2);
  EXPECT_LE(fine.largest_error, 1e-3);
  EXPECT_LE(fine.momentum_drift, 1e-6);
  EXPECT_LE(fine.energy_drift, 1e-6);
  EXPECT_GE(std::log2(coarse.largest_error / fine.largest_error), 1.9);
}

TEST(TorqueFreeRotation, IntermediateAxis) {
  const auto rows = read_rows(bundled_reference("torque_free_rotation/tennis_123.csv"));
  ASSERT_GT(rows.size(), 10u);
  const Vec3 inertia(1.0, 2.0, 3.0);
  const Turning fine = follow(rows, inertia, 1e-4, 3), coarse = follow(rows, inertia, 2e-4, 3);
  EXPECT_LE(fine.largest_error, 1e-4);
  EXPECT_LE(fine.momentum_drift, 1e-6);
  EXPECT_LE(fine.energy_drift, 1e-6);
  EXPECT_GE(std::log2(coarse.largest_error / fine.largest_error), 1.9);
}

// Each component of the angular momentum in space, over the same 12 s.
TEST(TorqueFreeRotation, AngularMomentumKeepsItsDirection) {
  const Vec3 inertia(1.0, 2.0, 3.0), start(0.01, 5.0, 0.0);
  Simulation simulation(free_body(inertia, start),
                        {.time_step = {.fraction = 1.0, .largest = 1e-4}, .largest_move = 1e3});
  simulation.run_until(12.0);
  const State& state = simulation.state();
  const Vec3 omega = state.orientation[0].conjugate() * state.angular_velocity[0];
  const Vec3 now = state.orientation[0] * inertia.cwiseProduct(omega);
  EXPECT_LT((now - inertia.cwiseProduct(start)).norm() / now.norm(), 1e-6);
}

// Period of omega from zero crossings of omega_x, linear between steps of 1e-4 s.
TEST(TorqueFreeRotation, PeriodOfTheIntermediateAxis) {
  const Vec3 inertia(1.0, 2.0, 3.0);
  Simulation simulation(free_body(inertia, {0.01, 5.0, 0.0}),
                        {.time_step = {.fraction = 1.0, .largest = 1e-4}, .largest_move = 1e3});
  std::vector<double> crossings;
  double last_time = 0.0, last = 0.0;
  const auto look = [&](const State& state) {
    const double now = (state.orientation[0].conjugate() * state.angular_velocity[0]).y();
    if (last * now < 0.0)
      crossings.push_back(last_time + (state.time - last_time) * last / (last - now));
    last_time = state.time;
    last = now;
  };
  simulation.run_until(20.0, {.interval = 1e-3, .observer = look});
  ASSERT_GE(crossings.size(), 3u);
  EXPECT_NEAR((crossings[2] - crossings[0]) / 10.532110248183, 1.0, 1e-6);
}

TEST(TorqueFreeRotation, LowerBarOfAPublishedCurve) {
  const auto rows =
      read_rows(outside_reference("torque_free_rotation/kratos_reference_points.csv"));
  if (rows.empty()) GTEST_SKIP() << "the published points are not beside the source folder";
  Simulation simulation(free_body({0.25, 0.25, 0.125}, {0.0, 1.0, 100.0}),
                        {.time_step = {.fraction = 1.0, .largest = 1e-4}, .largest_move = 1e3});
  for (const Row& row : rows) {
    simulation.run_until(number(row, "t_s"));
    const State& state = simulation.state();
    const Vec3 omega = state.orientation[0].conjugate() * state.angular_velocity[0];
    // The points are off the exact curve by up to 1e-2 themselves
    EXPECT_NEAR(omega.x(), number(row, "omega_x"), 2e-2);
    EXPECT_NEAR(omega.y(), number(row, "omega_y"), 2e-2);
  }
}

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
