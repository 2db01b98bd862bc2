#include "datasets/rigs/poured_bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace graintruth::datasets {

namespace {

// Between grains of a lattice, of their length
constexpr double loose_clearance = 0.3, close_clearance = 0.06;
constexpr double largest_class = 2.2;     // standard deviations above the mean, see narrowest_width
constexpr double longest_settling = 3.0;  // s
constexpr double most_grains = 100000.0;

}  // namespace

double grain_volume(const Particle& particle) {
  const auto ball = [](double radius) {
    return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  };
  double volume = 0.0;
  for (const SceneSphere& sphere : particle.model.spheres) volume += ball(sphere.radius);
  return volume > 0.0 ? volume : ball(0.5 * particle.diameter);
}

double poured_height(const Particle& particle, int count, double cross_section) {
  return count * grain_volume(particle) / (poured_fraction * cross_section);
}

double highest_level(const Particle& particle, double level, double depth) {
  constexpr double loosest = 1.2;  // 0.5 of the room is filled
  return loosest * level * depth / std::max(depth - 0.5 * particle.diameter, 0.5 * depth) +
         particle.diameter;
}

int poured_count(RigSection& section,
                 const RigContext& context,
                 const std::function<double(double level)>& room_below,
                 Rig& rig) {
  const Particle& particle = *context.particle;
  TomlSection& keys = section.rig();
  const auto mass = keys.optional_quantity("filled_mass", mass_units, positive);
  const auto level = keys.optional_quantity("filled_height", length_units, positive);
  const std::string mass_key = mass ? keys.key_of("filled_mass", mass_units) : "";
  const std::string level_key = level ? keys.key_of("filled_height", length_units) : "";
  if (particle.count > 0) {
    if (mass) keys.fail(mass_key, "says what particle.count says already; keep one of them");
    if (level) keys.fail(level_key, "says what particle.count says already; keep one of them");
    return particle.count;
  }
  if (mass && level) keys.fail(level_key, "says what 'filled_mass' says already; keep one of them");
  if (!mass && !level)
    keys.fail("filled_mass_g", "is missing; give it, filled_height_mm or particle.count");
  if (mass && !(particle.mass > 0.0))
    keys.fail(mass_key, "does not tell how many grains there are without particle.mass");
  const double count =
      mass ? *mass / particle.mass : room_below(*level) * poured_fraction / grain_volume(particle);
  const std::string& key = mass ? mass_key : level_key;
  if (count < 1.0) keys.fail(key, "is less than one grain");
  if (count > most_grains)
    keys.fail(
        key,
        fmt::format("makes {:.3g} grains, but at most {:.0f} are simulated", count, most_grains));
  rig.filled_count = static_cast<int>(std::lround(count));
  if (level && context.notes) {
    context.notes->push_back(
        fmt::format("rig.{} of {:.4g} mm is taken as {} grains, which fill {:.0f} % of the room "
                    "when they are poured loosely; a weighed filling is better known.",
                    level_key,
                    1e3 * *level,
                    rig.filled_count,
                    100.0 * poured_fraction));
  }
  return rig.filled_count;
}

double lattice_pitch(const Particle& particle, LatticeKind kind) {
  const double largest =
      particle.length * std::exp(largest_class * particle.model.size.standard_deviation);
  if (kind == LatticeKind::loose) return largest + loose_clearance * particle.length;
  return (largest + close_clearance * particle.length) * 2.0 / std::sqrt(3.0);
}

SceneFill filling_from_lattice(const Particle& particle,
                               LatticeKind kind,
                               const Eigen::Vector3d& low,
                               const Eigen::Vector3d& high,
                               const std::optional<SceneRoom>& within) {
  const bool is_close = kind == LatticeKind::close;
  const double clearance = (is_close ? close_clearance : loose_clearance) * particle.length;
  SceneFill fill{.method = SceneFill::Method::lattice,
                 .low = low,
                 .high = high,
                 .clearance = clearance,
                 // So that neighbours keep apart, along an axis or the diagonal of a cell
                 .jitter = 0.5 * clearance / (is_close ? std::sqrt(3.0) : 1.0),
                 .within = within};
  if (is_close) fill.body_centred = true;
  return fill;
}

void settle_poured_bed(double impact, Rig& rig) {
  // What falls against a drag of g/v falls with v at most
  rig.scene.phases.push_back({.name = "pour",
                              .duration = longest_settling,
                              .until_rest = true,
                              .fastest_impact = impact,
                              .global_damping = rig.gravity / impact});
  rig.scene.phases.push_back({.name = "settle",
                              .duration = longest_settling,
                              .until_rest = true,
                              .fastest_impact = impact});
  rig.scene.event_phase = static_cast<int>(rig.scene.phases.size());
}

void release_poured_bed(const Released& released, double impact, Rig& rig) {
  const double interval = released.interval;
  rig.scene.phases.push_back({.name = released.phase,
                              .duration = std::ceil(released.lasts / interval) * interval,
                              .output_interval = interval,
                              .fastest_impact = impact});
  rig.scene.phases.push_back({.name = "rest",
                              .duration = released.rests_at_most,
                              .until_rest = true,
                              .output_interval = interval,
                              .fastest_impact = impact});
}

SceneWall flat_wall(std::string name, std::vector<Eigen::Vector3d> corners) {
  SceneWall wall;
  wall.name = std::move(name);
  wall.material = wall_material;
  wall.kind = SceneWall::Kind::polygon;
  wall.points = std::move(corners);
  return wall;
}

}  // namespace graintruth::datasets
