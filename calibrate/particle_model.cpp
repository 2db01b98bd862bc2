#include "calibrate/particle_model.h"

#include <cmath>

#include "sim/profile.h"

namespace graintruth::calibrate {

namespace {

constexpr int plate_chords = 8;  // seven spheres

}  // namespace

std::vector<datasets::AxialSphere> element_spheres(const datasets::Particle& particle) {
  const auto& plate = particle.plate;
  if (!particle.spheres.empty() || !plate) return particle.spheres;
  // Spheres along the axis of a disc would all but coincide
  if (!plate->shows_angle()) return {{0.0, std::sqrt(plate->semi_major * plate->semi_minor)}};
  std::vector<datasets::AxialSphere> spheres;
  const auto outline = sim::ellipse_profile(plate->semi_major, plate->semi_minor);
  for (const sim::ElementSphere& sphere : sim::fit_profile(outline, plate_chords).spheres)
    spheres.push_back({sphere.centre.x(), sphere.radius});
  return spheres;
}

std::optional<std::array<double, 3>> stated_inertia(const datasets::Particle& particle) {
  const auto& plate = particle.plate;
  if (!plate) return std::nullopt;
  const double a = plate->semi_major * plate->semi_major;
  const double b = plate->semi_minor * plate->semi_minor;
  const double t = plate->thickness * plate->thickness / 3.0;
  // I = m/4 (sum of squared half axes across), a flat ellipse's; the thickness adds m t^2/12
  const double quarter = 0.25 * particle.mass;
  return {{quarter * (b + t), quarter * (a + b), quarter * (a + t)}};
}

}  // namespace graintruth::calibrate
