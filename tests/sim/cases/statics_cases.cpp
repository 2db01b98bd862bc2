// Bodies at rest: the wall carries their weight, at the overlap of Hertz.
#include <array>

#include "sim/simulation.h"
#include "tests/sim/cases/check.h"

namespace graintruth::sim::cases {
namespace {

constexpr double kWeight = 0.2105;  // N
constexpr double kRadius = 0.01;    // m

// `count` touching balls of 1 cm with the weight of chapter 3 on a rigid plane, dropped from just
// above it, `upright` on one of them.
Simulation resting(int count, bool planar, double fraction, bool upright = false) {
  Scene scene;
  scene.planar = planar;
  const int material = scene.add_material({3.5e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, {.friction = 0.2, .restitution = 0.3});
  const int type =
      scene.add_type(make_clump(chain_of_spheres(count, kRadius, 0.02), {.mass = kWeight / 9.81}));
  const double turn = upright ? std::acos(0.0) : 0.0;
  scene.add_planar_body(type, {0.0, kRadius + (upright ? 0.01 * (count - 1) : 0.0)}, turn);
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  Simulation simulation(scene, {.time_step = {.fraction = fraction}});
  simulation.run_until(0.05);
  return simulation;
}

// W/n = 4/3 E/(1 - nu^2) sqrt(R) d^1.5
double hertz_overlap(int contacts) {
  const double k = 4.0 / 3.0 * 3.5e9 / (1.0 - 0.09) * std::sqrt(kRadius);
  return std::pow(kWeight / contacts / k, 2.0 / 3.0);
}

std::vector<Check> weight() {
  Worst force, overlap;
  for (const bool planar : {true, false}) {
    for (int count = 1; count <= 9; ++count) {
      const Simulation simulation = resting(count, planar, 0.3);
      const auto contacts = simulation.contacts();
      if (static_cast<int>(contacts.size()) != count) force.see(NAN);
      force.see_ratio(-simulation.wall_force(0).z(), kWeight);
      for (const ContactReport& contact : contacts) {
        overlap.see_ratio(contact.overlap, hertz_overlap(count));
      }
    }
  }
  Worst printed;
  printed.see_ratio(resting(1, false, 0.3).contacts()[0].overlap, 5.523e-7);
  printed.see_ratio(resting(2, false, 0.3).contacts()[0].overlap, 3.479e-7);
  const std::string source = "thesis 3.2, model specification 5";
  return {within("force on 1 ... 9 contacts, relative", source, 1e-6, force.value),
          within("overlap of each, relative", "Hertz; errata 31", 1e-2, overlap.value),
          within("overlaps 5.523e-7 and 3.479e-7 m, relative",
                 "errata 31, digits as stated",
                 1.5e-4,
                 printed.value)};
}

// Tables 3.1 to 3.3 at rest: neither the force nor the overlap depends on the time step.
std::vector<Check> weight_at_any_step() {
  Worst upright, flat;
  for (const double fraction : {0.3, 0.1, 0.03}) {
    upright.see_ratio(resting(2, true, fraction, true).contacts()[0].overlap, hertz_overlap(1));
    flat.see_ratio(resting(2, true, fraction).contacts()[0].overlap, hertz_overlap(2));
  }
  const std::string source = "thesis tables 3.1-3.3; errata 31";
  return {
      within(
          "upright, overlap at 0.3, 0.1, 0.03 of the step, relative", source, 1e-2, upright.value),
      within("flat, the same", source, 1e-2, flat.value)};
}

constexpr std::array kCases = {
    Case{"Weight", "Weight on 1 to 9 contacts, chapter 3", weight},
    Case{"WeightAtAnyStep", "Weight at several time steps, chapter 3", weight_at_any_step}};

}  // namespace

std::span<const Case> statics_cases() { return kCases; }

}  // namespace graintruth::sim::cases
