#include "datasets/scene/scene_particle.h"

#include <fmt/format.h>

#include <cmath>

#include "datasets/scene/geometry_files.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

using Eigen::Vector3d;

constexpr Range length_range{0.0, 1e3, false, "a length above 0 and at most 1 km"};
constexpr Range place_range{-1e4, 1e4, true, "a place within 10 km of the origin"};
constexpr int most_spheres = 300;   // a particle
constexpr double round_off = 1e-9;  // of a radius; as the simulator allows it

std::vector<SceneSphere> read_spheres(TomlSection& section) {
  std::vector<SceneSphere> spheres;
  for (TomlSection& row : section.sections("spheres")) {
    SceneSphere sphere;
    if (const auto offset = row.optional_quantity("offset", length_units, place_range)) {
      sphere.centre.x() = *offset;  // on the long axis
      sphere.radius = row.quantity("radius", length_units, length_range);
      row.finish();
      spheres.push_back(sphere);
      continue;
    }
    sphere.centre = {row.optional_quantity("x", length_units, place_range).value_or(0.0),
                     row.optional_quantity("y", length_units, place_range).value_or(0.0),
                     row.optional_quantity("z", length_units, place_range).value_or(0.0)};
    sphere.radius = row.quantity("radius", length_units, length_range);
    row.finish();
    spheres.push_back(sphere);
  }
  if (spheres.empty()) section.fail("spheres", "holds no sphere");
  return spheres;
}

// A chain by radius and spacing, or by aspect ratio and the ball that it has the volume of.
void read_chain(TomlSection section, SceneParticle& particle) {
  const int count = section.whole_number("count", 1, most_spheres);
  if (section.has("aspect_ratio")) {
    const Range aspect_range{
        1.0, static_cast<double>(count), true, "an aspect ratio from 1 to the number of spheres"};
    SceneChain chain{count, section.quantity("aspect_ratio", plain, aspect_range), 0.0};
    chain.ball_radius = section.quantity("ball_radius", length_units, length_range);
    if (count > 1 && chain.aspect_ratio == 1.0) {
      section.fail("aspect_ratio", "is 1, which is one sphere: write count = 1");
    }
    particle.chain = chain;
  } else {
    const double radius = section.quantity("radius", length_units, length_range);
    const double spacing = section.quantity("spacing", length_units, length_range);
    for (int i = 0; i < count; ++i) {
      particle.spheres.push_back({Vector3d((i - 0.5 * (count - 1)) * spacing, 0.0, 0.0), radius});
    }
  }
  section.finish();
}

SceneProfile read_profile(TomlSection section,
                          const std::filesystem::path& folder,
                          std::vector<std::filesystem::path>& inputs) {
  SceneProfile profile;
  profile.chords = section.whole_number("chords", 2, 200);
  if (const auto ellipse = section.optional_numbers("ellipse", 2, length_units)) {
    profile.ellipse = {(*ellipse)[0], (*ellipse)[1]};
    if (!(profile.ellipse[0] > 0.0 && profile.ellipse[1] > 0.0)) {
      section.fail("ellipse_m", "must be two half-lengths above 0, along and across the axis");
    }
  } else if (const auto file = section.optional_text("file")) {
    const std::filesystem::path path = folder / *file;
    const Table table = read_csv(path);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      profile.points.push_back({table.number(row, "x_m"), table.number(row, "y_m")});
    }
    inputs.push_back(path);
  } else {
    for (const auto& row : section.rows("points", 2, length_units)) {
      profile.points.push_back({row[0], row[1]});
    }
    if (profile.points.empty()) {
      section.fail("points_m", "is missing; write points_mm = [[x, y], ...], ellipse_mm or file");
    }
  }
  section.finish();
  return profile;
}

// Under which a shape is stated; of several the last one that can be.
std::string shape_key(TomlSection& section) {
  for (const char* key : {"sphere_file", "profile", "chain", "spheres"}) {
    if (section.has(key)) return key;
  }
  return section.key_of("radius", length_units);
}

}  // namespace

double read_length_unit(TomlSection& section, std::string_view key) {
  const std::string name = section.text(key);
  for (const Unit& unit : length_units) {
    if (unit.suffix == name) return unit.in_si;
  }
  section.fail(key, fmt::format("is '{}', but must be 'm', 'cm' or 'mm'", name));
}

SizeSpread read_size_spread(TomlSection section) {
  SizeSpread size;
  const std::string kind = section.text("distribution");
  if (kind == "uniform") {
    size.kind = SizeSpread::Kind::uniform;
  } else if (kind == "normal") {
    size.kind = SizeSpread::Kind::normal;
  } else if (kind == "lognormal") {
    size.kind = SizeSpread::Kind::lognormal;
  } else {
    section.fail("distribution",
                 fmt::format("is '{}', but must be 'uniform', 'normal' or 'lognormal'", kind));
  }
  // Beyond a quarter the smallest classes of a normal distribution would be no bodies any more
  constexpr Range spread_range{0.0, 0.25, false, "a relative spread above 0 and at most 0.25"};
  size.standard_deviation = section.quantity("standard_deviation", plain, spread_range);
  size.classes = section.optional_whole_number("classes", 2, 31).value_or(7);
  section.finish();
  return size;
}

void read_particle_shape(TomlSection& section,
                         const std::filesystem::path& folder,
                         std::vector<std::filesystem::path>& inputs,
                         SceneParticle& particle) {
  int shapes = 0;
  if (const auto radius = section.optional_quantity("radius", length_units, length_range)) {
    particle.spheres = {{Vector3d::Zero(), *radius}};
    ++shapes;
  }
  if (section.has("spheres")) {
    particle.spheres = read_spheres(section);
    ++shapes;
  }
  if (auto chain = section.optional_section("chain")) {
    read_chain(*chain, particle);
    ++shapes;
  }
  if (auto profile = section.optional_section("profile")) {
    particle.profile = read_profile(*profile, folder, inputs);
    ++shapes;
  }
  if (const auto file = section.optional_text("sphere_file")) {
    const std::filesystem::path path = folder / *file;
    for (const ListedSphere& sphere :
         read_sphere_list(path, read_length_unit(section, "file_unit"))) {
      particle.spheres.push_back({sphere.centre, sphere.radius});
    }
    inputs.push_back(path);
    ++shapes;
  }
  if (particle.spheres.size() > most_spheres)
    section.fail(shape_key(section), fmt::format("has more than {} spheres", most_spheres));
  if (shapes != 1) {
    section.fail(shape_key(section),
                 fmt::format("{}; exactly one of radius_mm, spheres, chain, profile and "
                             "sphere_file is needed",
                             shapes == 0 ? std::string("is missing")
                                         : fmt::format("is one of {} shapes", shapes)));
  }
}

void require_one_layer(TomlSection& section, const SceneParticle& particle) {
  for (const SceneSphere& sphere : particle.spheres) {
    const double off = sphere.centre.y() - particle.spheres.front().centre.y();
    if (std::abs(off) <= round_off * sphere.radius) continue;
    section.fail(
        shape_key(section),
        fmt::format("has a ball {:.4g} mm out of the layer; grains in one layer have y = 0 "
                    "for every ball",
                    1e3 * off));
  }
}

}  // namespace graintruth::datasets
