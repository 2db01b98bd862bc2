#include "sim/laws/time_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

// The half-step predictor of the dashpot and the rotation of clumps stiffen a contact beyond the
// textbook spring.
constexpr double kStiffnessSafety = 0.5;

struct Impact {
  double normal_modulus, reduced_radius, reduced_mass;
  double
      turned_mass;  // kg; smallest mass that the contact can feel, rotation of the clumps included
  bool hardly_loses;  // energy
  // What the steps of a contact are multiplied with.
  double refinement() const { return hardly_loses ? kStepsWithoutLoss : 1.0; }
};

// Mass felt by a contact at the far end of a clump: 1/m + L^2/I, L the largest lever across the
// normal.
double inverse_mass_at_end(const Clump& clump) {
  double lever = 0.0;
  for (const ElementSphere& sphere : clump.spheres) lever = std::max(lever, sphere.centre.norm());
  return 1.0 / clump.mass + lever * lever / clump.inertia.minCoeff();
}

double largest_radius(const Clump& clump) {
  double radius = 0.0;
  for (const ElementSphere& sphere : clump.spheres) radius = std::max(radius, sphere.radius);
  return radius;
}

double normal_modulus(const Material& first, const Material& second) {
  return mix(first, second, Surfaces{}, Tension::allowed, 0.0).normal_modulus;
}

std::vector<Impact> possible_impacts(const Scene& scene) {
  std::map<int, int> used;  // how many bodies of a type
  for (const Body& body : scene.bodies) ++used[body.type];
  const auto hardly_loses = [&scene](int first, int second) {
    return scene.surfaces.of(first, second).restitution > kHardlyLoses;
  };
  std::vector<Impact> impacts;
  for (const auto& [i, count] : used) {
    const Clump& a = scene.types[i];
    for (const auto& [j, count_of_other] : used) {
      const Clump& b = scene.types[j];
      const double ra = largest_radius(a), rb = largest_radius(b);
      impacts.push_back({normal_modulus(scene.materials[a.material], scene.materials[b.material]),
                         ra * rb / (ra + rb),
                         a.mass * b.mass / (a.mass + b.mass),
                         1.0 / (inverse_mass_at_end(a) + inverse_mass_at_end(b)),
                         // A body does not meet itself
                         (i != j || count > 1) && hardly_loses(a.material, b.material)});
    }
    for (const Wall& wall : scene.walls) {
      impacts.push_back(
          {normal_modulus(scene.materials[a.material], scene.materials[wall.material]),
           largest_radius(a),
           a.mass,
           1.0 / inverse_mass_at_end(a),
           hardly_loses(a.material, wall.material)});
    }
  }
  return impacts;
}

}  // namespace

double rayleigh_time_step(double radius, double density, const Material& material) {
  return std::numbers::pi * radius * std::sqrt(density / shear_modulus(material)) /
         (0.1631 * material.poisson_ratio + 0.8766);
}

double stiffness_time_step(double mass, double stiffness) {
  return 2.0 * std::sqrt(mass / stiffness);
}

HertzImpact hertz_impact(double normal_modulus,
                         double reduced_radius,
                         double reduced_mass,
                         double speed) {
  const double k = 4.0 / 3.0 * normal_modulus * std::sqrt(reduced_radius);
  HertzImpact impact;
  impact.deepest_overlap = exact_pow(1.25 * reduced_mass * speed * speed / k, 0.4);
  impact.largest_force = k * exact_pow(impact.deepest_overlap, 1.5);
  impact.duration = 2.9432751843247 * impact.deepest_overlap / speed;
  return impact;
}

TimeStepLimits time_step_limits(const Scene& scene, double impact_speed) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  TimeStepLimits limits{kNone, kNone, kNone, kNone};
  for (const Body& body : scene.bodies) {
    const Clump& type = scene.types[body.type];
    limits.rayleigh = std::min(
        limits.rayleigh,
        rayleigh_time_step(
            type.smallest_radius, type.mass / type.volume, scene.materials[type.material]));
  }
  for (const Impact& impact : possible_impacts(scene)) {
    const HertzImpact hertz = hertz_impact(
        impact.normal_modulus, impact.reduced_radius, impact.reduced_mass, impact_speed);
    limits.contact_duration = std::min(limits.contact_duration, hertz.duration);
    limits.refined_duration =
        std::min(limits.refined_duration, hertz.duration / impact.refinement());
    const double stiffness =
        2.0 * impact.normal_modulus * std::sqrt(impact.reduced_radius * hertz.deepest_overlap);
    limits.stiffness =
        std::min(limits.stiffness, stiffness_time_step(impact.turned_mass, stiffness));
  }
  return limits;
}

double critical_time_step(const Scene& scene) { return time_step_limits(scene, 1.0).rayleigh; }

double choose_time_step(const Scene& scene, const TimeStepOptions& options) {
  if (!(options.fraction > 0.0 && options.fraction <= 1.0)) {
    throw std::invalid_argument("TimeStepOptions: fraction is " + std::to_string(options.fraction) +
                                ", must be above 0 and at most 1: a longer step than Rayleigh's is "
                                "unstable");
  }
  if (!(options.impact_speed > 0.0 && options.steps_per_contact > 0.0 && options.largest >= 0.0)) {
    throw std::invalid_argument(
        "TimeStepOptions: impact_speed and steps_per_contact must be above 0, largest not below 0");
  }
  const TimeStepLimits limits = time_step_limits(scene, options.impact_speed);
  double step = std::min({options.fraction * limits.rayleigh,
                          limits.refined_duration / options.steps_per_contact,
                          kStiffnessSafety * limits.stiffness});
  if (options.largest > 0.0) step = std::min(step, options.largest);
  return step;
}

double linear_time_step(const Scene& scene, double stiffness, const TimeStepOptions& options) {
  double step = std::numeric_limits<double>::infinity();
  for (const Impact& impact : possible_impacts(scene)) {
    const double duration = std::numbers::pi * std::sqrt(impact.reduced_mass / stiffness);
    step = std::min({step,
                     duration / (impact.refinement() * options.steps_per_contact),
                     kStiffnessSafety * stiffness_time_step(impact.turned_mass, stiffness)});
  }
  return step;
}

}  // namespace graintruth::sim
