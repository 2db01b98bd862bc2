#include "datasets/experiment/particle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/scene/scene_particle.h"
#include "datasets/store/plausible.h"

namespace graintruth::datasets {

namespace {

constexpr int plate_chords = 8;  // seven spheres

EllipticalPlate read_plate(TomlSection section) {
  const EllipticalPlate plate{section.quantity("semi_major", length_units, positive),
                              section.quantity("semi_minor", length_units, positive),
                              section.quantity("thickness", length_units, positive)};
  if (plate.semi_minor > plate.semi_major) {
    section.fail(section.has("semi_minor_mm") ? "semi_minor_mm" : "semi_minor_m",
                 "must not exceed semi_major (both are half axes)");
  }
  section.finish();
  return plate;
}

// Of a flat ellipse of this thickness, kg m2, about the axes along the long axis, across the
// picture and upright to the long axis in the picture: I = m/4 (sum of squared half axes across),
// and the thickness adds m t^2/12.
Eigen::Vector3d inertia_of(const EllipticalPlate& plate, double mass) {
  const double a = plate.semi_major * plate.semi_major;
  const double b = plate.semi_minor * plate.semi_minor;
  const double t = plate.thickness * plate.thickness / 3.0;
  const double quarter = 0.25 * mass;
  return {quarter * (b + t), quarter * (a + b), quarter * (a + t)};
}

// Seven spheres inscribed in its outline (thesis Appendix E), of a disc one of the same area, where
// the spheres are not stated; the inertia of a plate, whatever spheres stand for it.
void use_plate(const EllipticalPlate& plate, Particle& particle) {
  SceneParticle& model = particle.model;
  if (model.spheres.empty()) {
    // Spheres along the axis of a disc would all but coincide
    if (plate.shows_angle()) {
      model.profile =
          SceneProfile{.ellipse = {plate.semi_major, plate.semi_minor}, .chords = plate_chords};
    } else {
      model.spheres = {{Eigen::Vector3d::Zero(), std::sqrt(plate.semi_major * plate.semi_minor)}};
    }
  }
  model.inertia = inertia_of(plate, particle.mass);
  particle.body = NamedBody{"plate",
                            {{"semi_major", plate.semi_major},
                             {"semi_minor", plate.semi_minor},
                             {"thickness", plate.thickness}}};
  particle.diameter = 2.0 * std::sqrt(plate.semi_major * plate.semi_minor);
  particle.seen_area = std::numbers::pi * plate.semi_major * plate.semi_minor;
  particle.length = 2.0 * plate.semi_major;
  particle.half_width = plate.semi_minor;
  particle.thickness = plate.thickness;
  particle.shows_angle = plate.shows_angle();
}

// Of circles in the picture, each counted whole where they overlap.
double area_of(const std::vector<SceneSphere>& spheres) {
  double area = 0.0;
  for (const SceneSphere& sphere : spheres)
    area += std::numbers::pi * sphere.radius * sphere.radius;
  return area;
}

// From the origin to the farthest point, twice: shapes lie about their middle.
double length_of(const SceneParticle& model) {
  double reach = model.chain ? model.chain->aspect_ratio * model.chain->ball_radius : 0.0;
  for (const SceneSphere& sphere : model.spheres)
    reach = std::max(reach, sphere.centre.norm() + sphere.radius);
  if (const auto& profile = model.profile) {
    reach = std::max(reach, profile->ellipse[0]);
    for (const auto& [x, y] : profile->points) reach = std::max(reach, std::hypot(x, y));
  }
  return 2.0 * reach;
}

void use_model(Particle& particle) {
  const SceneParticle& model = particle.model;
  const double radius = largest_radius(model);
  particle.thickness = 2.0 * radius;
  particle.length = length_of(model);
  particle.half_width = radius;
  for (const SceneSphere& sphere : model.spheres) {
    if (sphere.centre.y() != 0.0 || sphere.centre.z() != 0.0) {
      particle.spheres.clear();
      break;
    }
    particle.spheres.push_back({sphere.centre.x(), sphere.radius});
  }
  particle.shows_angle = model.spheres.size() != 1;
  particle.seen_area =
      model.spheres.empty() ? std::numbers::pi * radius * radius : area_of(model.spheres);
  if (model.profile && model.profile->points.empty())
    particle.seen_area = std::numbers::pi * model.profile->ellipse[0] * model.profile->ellipse[1];
  particle.diameter = 2.0 * std::sqrt(particle.seen_area / std::numbers::pi);
}

}  // namespace

void set_count(int count, Particle& particle) { particle.count = particle.model.count = count; }

Particle read_particle(TomlSection section,
                       Purpose purpose,
                       bool rig_may_count,
                       const std::filesystem::path& folder,
                       std::vector<std::filesystem::path>& inputs) {
  const bool only_tracked = purpose == Purpose::tracking;
  Particle particle;
  auto plate = section.optional_section("plate");
  if (section.has("body")) {
    if (plate) section.fail("body", "is given beside 'plate'; keep one of them");
    particle.body = read_named_body(section);
  }
  // 1. How many, and how heavy; named bodies that are only tracked may come and go
  const auto count = section.optional_whole_number("count", 1, 100000);
  if (!count && !rig_may_count && !(only_tracked && particle.body))
    section.whole_number("count", 1, 100000);
  set_count(count.value_or(0), particle);
  const auto mass = section.optional_quantity("mass", mass_units, positive);
  if (!mass && !only_tracked) section.quantity("mass", mass_units, positive);
  particle.mass = mass.value_or(0.0);
  // 2. The shape
  particle.model.name = "particle";
  const bool has_shape = section.has("spheres") || section.has("chain") || section.has("profile") ||
                         section.has("sphere_file") || section.has("radius_mm") ||
                         section.has("radius_cm") || section.has("radius_m");
  if (has_shape) {
    read_particle_shape(section, folder, inputs, particle.model);
    use_model(particle);
  } else if (!plate && !(only_tracked && particle.body)) {
    section.fail("spheres",
                 "is missing; write spheres = [{offset_mm = ..., radius_mm = ...}, ...]");
  }
  particle.model.mass = particle.mass;
  if (plate) use_plate(read_plate(*std::move(plate)), particle);
  if (auto size = section.optional_section("size")) particle.model.size = read_size_spread(*size);
  section.finish();
  return particle;
}

Particle particle_of(const SceneParticle& model, int count) {
  Particle particle;
  particle.count = count;
  particle.model = model;
  particle.mass = model.mass.value_or(std::numeric_limits<double>::quiet_NaN());
  use_model(particle);
  return particle;
}

Particle particle_of(const SceneData& scene) {
  if (scene.particles.empty()) return {};
  int count = static_cast<int>(scene.places.size());
  for (const SceneParticle& one : scene.particles) count += one.count;
  return particle_of(scene.particles.front(), count);
}

double narrowest_width(const Particle& particle, Passage passage) {
  // The middle of the lowest class of 31 lies 2.14 standard deviations below the mean
  constexpr double lowest_class = 2.2;
  const double across = 2.0 * particle.half_width;
  const double narrowest =
      passage == Passage::in_one_layer ? across : std::min(across, particle.thickness);
  return narrowest * std::max(0.0, 1.0 - lowest_class * particle.model.size.standard_deviation);
}

// The volume is at most that of the upright block around what is seen, and at least that of the
// largest ball which has room in it.
DensityBounds density_bounds(const Particle& particle) {
  const double across = 2.0 * particle.half_width;
  const double block = std::max(particle.seen_area, particle.length * across) * particle.thickness;
  const double diameter = std::min(across, particle.thickness);
  const double ball = std::numbers::pi / 6.0 * diameter * diameter * diameter;
  if (!(particle.mass > 0.0) || !(ball > 0.0) || !(block > 0.0))
    return {0.0, std::numeric_limits<double>::infinity()};
  return {particle.mass / block, particle.mass / ball};
}

void check_density(TomlSection section,
                   const Particle& particle,
                   const std::filesystem::path& file,
                   std::vector<std::string>& notes) {
  const auto [lower, upper] = density_bounds(particle);
  if (lower > densest_solid) {
    section.fail(
        section.key_of("mass", mass_units),
        fmt::format("is {:.4g} g, which with this shape makes {:.4g} kg/m3 or more, but no "
                    "solid has more than {:.0f} kg/m3; look at the units of both",
                    1e3 * particle.mass,
                    lower,
                    densest_solid));
  }
  if (upper < lightest_solid) {
    notes.push_back(fmt::format(
        "{}: particle.{} is {:.4g} g, which with this shape makes {:.4g} kg/m3 or less, but solids "
        "have {:.0f} kg/m3 or more; look at the units of both.",
        file.string(),
        section.key_of("mass", mass_units),
        1e3 * particle.mass,
        upper,
        lightest_solid));
  }
}

double largest_radius(const SceneParticle& model) {
  double radius = 0.0;
  for (const SceneSphere& sphere : model.spheres) radius = std::max(radius, sphere.radius);
  if (model.chain) radius = std::max(radius, model.chain->ball_radius);
  if (const auto& profile = model.profile) {
    radius = std::max(radius, profile->ellipse[1]);
    for (const auto& [x, y] : profile->points) radius = std::max(radius, y);
  }
  return radius;
}

}  // namespace graintruth::datasets
