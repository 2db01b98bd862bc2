// Free bodies: falling, damped, turning, and one push.
#include <array>

#include "sim/engine/integrate.h"
#include "sim/simulation.h"
#include "tests/sim/cases/check.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim::cases {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::outside_reference;
using tests::read_rows;
using tests::Row;

const std::string kRotation = "torque_free_rotation";

// --- Translation ---

Scene free_chain(bool planar, const Vec3& velocity) {
  Scene scene;
  scene.planar = planar;
  scene.add_material({1e7, 0.3});
  const int type = scene.add_type(make_clump(chain_of_spheres(2, 0.01, 0.01), {.density = 2000.0}));
  scene.add_body(type, Vec3::Zero(), Quat::Identity(), velocity);
  return scene;
}

// Error of the place, m, after a fall with global damping f from v0 = 2 m/s upwards:
//   z = (v0 + g/f) (1 - exp(-f t))/f - g t/f
double damped_fall_error(double time_step) {
  constexpr double kDamping = 20.0, kTime = 0.04, kGravity = 9.81;
  Simulation simulation(free_chain(true, {0.0, 0.0, 2.0}),
                        {.time_step = {.fraction = 1.0, .impact_speed = 1e-6, .largest = time_step},
                         .global_damping = kDamping,
                         .largest_move = 1.0});
  simulation.run_until(kTime);
  const double last = kGravity / kDamping;
  const double exact = (2.0 + last) * (1.0 - std::exp(-kDamping * kTime)) / kDamping - last * kTime;
  return simulation.state().position[0].z() - exact;
}

std::vector<Check> falling() {
  Worst place, speed;
  for (const bool planar : {true, false}) {
    Simulation simulation(free_chain(planar, {1.0, 0.0, 2.0}));
    simulation.run_until(0.04);
    const State& state = simulation.state();
    place.see(state.position[0].z() - (2.0 * 0.04 - 0.5 * 9.81 * 0.0016));
    place.see(state.position[0].x() - 0.04);
    speed.see(state.velocity[0].z() - (2.0 - 9.81 * 0.04));
  }
  // Exact for a leapfrog with v(-1/2) = v0 - g dt/2, up to the round-off of a few thousand
  // additions
  return {within("free fall: place after 0.04 s, m", "parabola; round-off", 1e-13, place.value),
          within("free fall: speed after 0.04 s, m/s", "parabola; round-off", 1e-12, speed.value),
          order_of("fall with global damping: order of accuracy",
                   "exponential (thesis 1.76-1.83); validation plan 2",
                   1.9,
                   observed_order(damped_fall_error(2e-4), damped_fall_error(1e-4)))};
}

// Thesis 3.7-3.10: 1000 N for one step of 8.61e-6 s at a lever of 1.5 cm.
std::vector<Check> one_push() {
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
  Worst speed, spin;
  speed.see_ratio(bodies.motion[0].velocity.z, 1000.0 * 8.61e-6 / 0.0243);
  spin.see_ratio(bodies.motion[0].spin, 15.0 * 8.61e-6 / 2.433e-5);
  const std::string source = "thesis 3.7-3.10, model specification 10";
  return {within("speed, 0.354321 m/s, relative", source, 1e-9, speed.value),
          within("spin, 5.30826 rad/s, relative", source, 1e-9, spin.value)};
}

// --- Rotation ---

Scene free_body(const Vec3& inertia, const Vec3& spin) {
  Scene scene;
  scene.gravity.setZero();
  scene.add_material({1e6, 0.3});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(1, 1.0, 0.0), {.mass = 1.0, .inertia = inertia}));
  scene.add_body(type, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), spin);
  return scene;
}

SimulationOptions turning_options(double time_step) {
  return {.time_step = {.fraction = 1.0, .largest = time_step}, .largest_move = 1e3};
}

Vec3 omega_in_body(const State& state) {
  return state.orientation[0].conjugate() * state.angular_velocity[0];
}

// The two files name their columns differently.
Vec3 omega_of(const Row& row) {
  if (row.contains("w1")) return {number(row, "w1"), number(row, "w2"), number(row, "w3")};
  return {number(row, "omega_x"), number(row, "omega_y"), number(row, "omega_z")};
}

struct Turning {
  Worst omega;     // rad/s; largest error in body axes
  Worst momentum;  // relative; of each component of the vector in space, over its length
  Worst energy;    // relative
};

// `axes`: how many components of omega have a tolerance.
Turning follow(const std::vector<Row>& rows, const Vec3& inertia, double time_step, int axes) {
  const Vec3 start = omega_of(rows[0]);
  Simulation simulation(free_body(inertia, start), turning_options(time_step));
  Turning result;
  const Vec3 momentum = inertia.cwiseProduct(start);
  for (const Row& row : rows) {
    simulation.run_until(number(row, "t_s"));
    const State& state = simulation.state();
    const Vec3 omega = omega_in_body(state);
    result.omega.see((omega - omega_of(row)).head(axes).cwiseAbs().maxCoeff());
    const Vec3 now = state.orientation[0] * inertia.cwiseProduct(omega);
    result.momentum.see((now - momentum).cwiseAbs().maxCoeff() / momentum.norm());
    result.energy.see_ratio(omega.dot(inertia.cwiseProduct(omega)), start.dot(momentum));
  }
  return result;
}

std::vector<Check> checks_of(const std::string& file,
                             const Vec3& inertia,
                             int axes,
                             double tolerance) {
  const auto rows = read_rows(bundled_reference("torque_free_rotation/" + file));
  const Turning fine = follow(rows, inertia, 1e-4, axes),
                coarse = follow(rows, inertia, 2e-4, axes);
  return {
      within("largest error of omega at dt 1e-4 s, rad/s", kRotation, tolerance, fine.omega.value),
      within(
          "drift of each component of the angular momentum", kRotation, 1e-6, fine.momentum.value),
      within("drift of the energy", kRotation, 1e-6, fine.energy.value),
      order_of("order of accuracy in the time step",
               kRotation,
               1.9,
               observed_order(coarse.omega.value, fine.omega.value))};
}

std::vector<Check> symmetric_body() {
  return checks_of("omega_exact.csv", {0.25, 0.25, 0.125}, 2, 1e-3);
}

// Period of omega from zero crossings of omega_y, linear between looks every 1e-3 s.
double period_error() {
  Simulation simulation(free_body({1.0, 2.0, 3.0}, {0.01, 5.0, 0.0}), turning_options(1e-4));
  std::vector<double> crossings;
  double last_time = 0.0, last = 0.0;
  const auto look = [&](const State& state) {
    const double now = omega_in_body(state).y();
    if (last * now < 0.0) {
      crossings.push_back(last_time + (state.time - last_time) * last / (last - now));
    }
    last_time = state.time;
    last = now;
  };
  simulation.run_until(20.0, {.interval = 1e-3, .observer = look});
  return crossings.size() < 3 ? NAN : (crossings[2] - crossings[0]) / 10.532110248183 - 1.0;
}

std::vector<Check> intermediate_axis() {
  std::vector<Check> checks = checks_of("tennis_123.csv", {1.0, 2.0, 3.0}, 3, 1e-4);
  Worst period;
  period.see(period_error());
  checks.push_back(
      within("period, relative", kRotation + ", elliptic integral", 1e-6, period.value));
  return checks;
}

// The points of the curve are off the exact one by up to 1e-2 themselves.
std::vector<Check> published_rotation() {
  const std::string source = "Kratos benchmark 30 (itself off by up to 1e-2)";
  const std::string what = "omega_x, omega_y at the published points, rad/s";
  const auto rows =
      read_rows(outside_reference("torque_free_rotation/kratos_reference_points.csv"));
  if (rows.empty()) return {missing(what, source)};
  Simulation simulation(free_body({0.25, 0.25, 0.125}, {0.0, 1.0, 100.0}), turning_options(1e-4));
  Worst worst;
  for (const Row& row : rows) {
    simulation.run_until(number(row, "t_s"));
    const Vec3 omega = omega_in_body(simulation.state());
    worst.see(omega.x() - number(row, "omega_x"));
    worst.see(omega.y() - number(row, "omega_y"));
  }
  return {within(what, source, 2e-2, worst.value)};
}

constexpr std::array kCases = {
    Case{"Falling", "Free fall, with and without damping", falling},
    Case{"OnePush", "One push at a lever, chapter 3", one_push},
    Case{"SymmetricBody", "Free rotation of a symmetric body", symmetric_body},
    Case{"IntermediateAxis", "Free rotation about the intermediate axis", intermediate_axis},
    Case{"PublishedRotation", "Free rotation: a published curve", published_rotation}};

}  // namespace

std::span<const Case> rotation_cases() { return kCases; }

}  // namespace graintruth::sim::cases
