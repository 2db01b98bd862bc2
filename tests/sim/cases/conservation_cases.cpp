// What must not change: momentum, energy up to the losses that are booked, and the physics seen
// from elsewhere: turned, mirrored, renumbered, in other units, in space instead of the layer.
#include <array>
#include <random>

#include "sim/simulation.h"
#include "tests/sim/cases/check.h"
#include "tests/sim/cases/invariance.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim::cases {
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
  // One draw a statement: compilers draw arguments of one call in different orders
  const auto part = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  const auto parts = [&] {
    const double z = part(), y = part(), x = part();
    return Vec3(x, y, z);
  };
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 place(0.06 * (i - 1.5), 0.0, 0.06 * (k - 1.0));
      if (planar) {
        const double v_z = part(), v_x = part(), spin = part(), angle = part();
        const Vec2 velocity = -5.0 * into_plane(place) + 0.3 * Vec2(v_x, v_z);
        scene.add_planar_body(type, into_plane(place), 3.0 * angle, velocity, 5.0 * spin);
      } else {
        const Vec3 velocity = -5.0 * place + 0.3 * parts();
        const Vec3 axis = parts();
        const Quat orientation = Quat(part(), axis.x(), axis.y(), axis.z()).normalized();
        scene.add_body(type, place, orientation, velocity, 5.0 * parts());
      }
    }
  }
  return scene;
}

const char* name_of(bool planar) { return planar ? "in the layer: " : "in space: "; }

Vec3 linear_momentum(const Scene& scene, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& velocity : state.velocity) sum += scene.types[0].mass * velocity;
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

std::vector<Check> momentum() {
  std::vector<Check> checks;
  for (const bool planar : {true, false}) {
    const Scene scene = cloud(planar, {.friction = 0.3, .restitution = 0.7}, 1);
    Simulation simulation(scene, {.time_step = {.fraction = 0.2}});
    const Vec3 linear = linear_momentum(scene, simulation.state());
    const Vec3 angular = angular_momentum(scene, simulation.state());
    const double scale = 12 * scene.types[0].mass * 0.5;  // N s; of the bodies at 0.5 m/s
    const bool touched = simulation.run_until(0.2).mean_contacts > 0.01;
    const State& state = simulation.state();
    Worst line, turn;
    line.see(touched ? (linear_momentum(scene, state) - linear).norm() / scale : NAN);
    turn.see((angular_momentum(scene, state) - angular).norm() / (0.1 * scale));
    checks.push_back(within(std::string(name_of(planar)) + "linear momentum, of that of the bodies",
                            "Newton's third law; round-off",
                            1e-12,
                            line.value));
    // Velocities at whole steps are predicted; those at half steps keep it to round-off
    checks.push_back(within(std::string(name_of(planar)) + "angular momentum, the same",
                            "leapfrog, velocities predicted at whole steps",
                            1e-7,
                            turn.value));
  }
  return checks;
}

std::vector<Check> energy() {
  std::vector<Check> checks;
  for (const bool planar : {true, false}) {
    Simulation elastic(cloud(planar, {}, 2), {.time_step = {.fraction = 0.1}});
    const double whole = elastic.energy().total();
    elastic.run_until(0.2);
    Worst drift;
    drift.see_ratio(elastic.energy().total(), whole);
    checks.push_back(within(std::string(name_of(planar)) + "elastic, frictionless: drift",
                            "validation plan 2",
                            1e-4,
                            drift.value));
    Simulation lossy(cloud(planar, {.friction = 0.3, .restitution = 0.6}, 3),
                     {.time_step = {.fraction = 0.1}, .tally_work = true});
    const double before = lossy.energy().total();
    lossy.run_until(0.2);
    const Energy after = lossy.energy();
    const double lost = before - after.total();
    Worst books;
    books.see_ratio(after.damping_loss + after.friction_loss, lost);
    if (!(lost > 0.05 * before && after.damping_loss > 0.0 && after.friction_loss > 0.0)) {
      books.see(NAN);  // there was nothing to book
    }
    checks.push_back(within(std::string(name_of(planar)) + "booked losses against what is gone",
                            "validation plan 2",
                            1e-2,
                            books.value));
  }
  return checks;
}

constexpr std::array kCases = {
    Case{"Momentum", "Momentum of colliding clumps", momentum},
    Case{"EnergyLedger", "Energy ledger of colliding clumps", energy},
    Case{"Invariance", "The same physics seen from elsewhere", invariance_checks}};

}  // namespace

std::span<const Case> conservation_cases() { return kCases; }

}  // namespace graintruth::sim::cases
