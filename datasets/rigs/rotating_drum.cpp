// A short drum between two panes that turn with it, partly full, turning steadily about the line of
// sight. The origin is the drum's axis, in the inner face of the front pane.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/rigs/poured_bed.h"

namespace graintruth::datasets {

namespace {

constexpr double pi = std::numbers::pi;
// From rest the bed is carried up by this angle before anything is recorded: more than the steepest
// slope, so that it has begun to flow.
constexpr double spin_up_angle = pi / 3.0;
constexpr double seen_share = 0.85;  // of the radius, where a free surface ends in all drums

SceneMotion turning_about_y(double rate) {
  SceneMotion motion;
  motion.angular_velocity = {0.0, rate, 0.0};
  return motion;
}

SceneWall pane(std::string name, double y, double inwards, double rate) {
  SceneWall wall;
  wall.name = std::move(name);
  wall.material = wall_material;
  wall.kind = SceneWall::Kind::plane;
  wall.points = {{0.0, y, 0.0}};
  wall.normal = {0.0, inwards, 0.0};
  wall.drag = turning_about_y(rate);
  return wall;
}

// How high lattice sites must be filled up for so many grains; the drum's radius where all are not
// enough.
double top_of_filling(const Particle& particle, int count, double radius, double depth) {
  const double pitch = lattice_pitch(particle, LatticeKind::close);
  const double room = radius - 0.5 * particle.length;
  const auto side = static_cast<long>(std::floor(2.0 * radius / pitch + 1e-9));
  const auto rows = static_cast<long>(std::floor(depth / pitch + 1e-9));
  long sites = 0;
  // Every second layer lies in the middles of the cells, whose last row is half outside
  for (long k = 0; k < 2 * side; ++k) {
    const double aside = k % 2 == 1 ? 1.0 : 0.5;
    const double z = 0.5 * (static_cast<double>(k) + 1.0) * pitch - radius;
    for (long i = 0; i < side; ++i) {
      const double x = (static_cast<double>(i) + aside) * pitch - radius;
      if (std::hypot(x, z) <= room) sites += k % 2 == 1 ? rows - 1 : rows;
    }
    if (sites >= count) return std::min(radius, z + pitch);
  }
  return radius;
}

// m: how deep grains are that fill this share of a circle. A segment of depth h has the share
// (R^2 acos((R - h)/R) - (R - h) sqrt(2 R h - h^2)) / (pi R^2).
double segment_share(double depth, double radius) {
  const double h = std::min(depth, 2.0 * radius), off = radius - h;
  return (radius * radius * std::acos(off / radius) - off * std::sqrt(2.0 * radius * h - h * h)) /
         (pi * radius * radius);
}

double depth_of(double share, double radius) {
  double low = 0.0, high = 2.0 * radius;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (low + high);
    (segment_share(middle, radius) < share ? low : high) = middle;
  }
  return low;
}

// Between two radii and two angles, rad from +x.
SeenOutline::Polygon sector(double inner, double outer, double from, double to) {
  constexpr int steps = 24;
  SeenOutline::Polygon corners;
  const auto add = [&](double radius, int step) {
    const double angle = from + (to - from) * step / steps;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int step = 0; step <= steps; ++step) add(outer, step);
  for (int step = steps; step >= 0; --step) add(inner, step);
  return corners;
}

// The bed leans by some 30 degrees the way the drum turns. Grains lie in the middle of it, whatever
// their slope, and none opposite.
void tell_what_is_seen(double radius, double share, double rate, SeenOutline& seen) {
  constexpr double lean = pi / 6.0, half_angle = pi / 6.0;
  const double depth = depth_of(share, radius);
  const double bed = -0.5 * pi - (rate < 0.0 ? -lean : lean);
  seen.from_x = -seen_share * radius;
  seen.to_x = seen_share * radius;
  seen.floor_z = -radius;
  seen.grains_after = {
      sector(radius - 0.4 * depth, 0.95 * radius, bed - half_angle, bed + half_angle)};
  seen.empty = {sector(
      radius - 0.4 * (2.0 * radius - depth), radius, bed + pi - half_angle, bed + pi + half_angle)};
  seen.drum = SeenOutline::Drum{.centre = {0.0, 0.0}, .radius = radius, .turning = -rate};
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  const Particle& particle = *context.particle;
  TomlSection& keys = section.rig();
  const double radius = 0.5 * keys.quantity("drum_diameter", length_units, positive);
  const double depth = keys.quantity("drum_depth", length_units, positive);
  // Clockwise as filmed is right-handed about y, which points away from the camera
  const double rate = section.setting("turning", turning_units, any_number, rig).value_or(0.0);
  if (!rig.settings.empty() && rate == 0.0)
    section.fail("turning", turning_units, "is 0, but the drum turns; below 0 counter-clockwise");
  // Of a drum so long that its ends do not matter
  const bool is_slice = keys.optional_flag("periodic_depth").value_or(false);
  const double room = pi * radius * radius * depth;  // m3
  if (depth < particle.length) {
    keys.fail(
        keys.key_of("drum_depth", length_units),
        fmt::format(
            "is {:.4g} mm, but a grain is {:.4g} mm long", 1e3 * depth, 1e3 * particle.length));
  }
  if (is_slice && depth < 2.0 * particle.length) {
    keys.fail(
        keys.key_of("drum_depth", length_units),
        fmt::format("is {:.4g} mm, but a periodic slice is at least two grains deep, {:.4g} mm",
                    1e3 * depth,
                    2e3 * particle.length));
  }
  const int count = poured_count(
      section, context, [&](double level) { return room * segment_share(level, radius); }, rig);
  const double share = count * grain_volume(particle) / (poured_fraction * room);
  const double top = top_of_filling(particle, count, radius, depth);
  if (top >= radius) {
    keys.fail(keys.key_of("drum_diameter", length_units),
              fmt::format("makes a drum that {} grains fill to {:.0f} %; there must be room for "
                          "them to flow",
                          count,
                          100.0 * share));
  }
  // 1. Walls: the surfaces move, the drum stays where it is
  SceneWall shell;
  shell.name = "shell";
  shell.material = wall_material;
  shell.kind = SceneWall::Kind::cylinder;
  shell.points = {{0.0, -particle.length, 0.0}, {0.0, depth + particle.length, 0.0}};
  shell.radius = radius;
  shell.drag = turning_about_y(rate);
  if (is_slice) {
    rig.scene.walls = {shell};
    rig.scene.period = {.low = {0.0, 0.0, 0.0}, .length = {0.0, depth, 0.0}};
  } else {
    rig.scene.walls = {
        shell, pane("glass_front", 0.0, 1.0, rate), pane("glass_rear", depth, -1.0, rate)};
  }
  rig.scene.fill = filling_from_lattice(
      particle,
      LatticeKind::close,
      {-radius, 0.0, -radius},
      {radius, depth, top},
      SceneRoom{.from = Eigen::Vector3d::Zero(), .to = {0.0, depth, 0.0}, .radius = radius});
  // 2. Phases. Grains come down the slope from grain to grain, half a diameter at a time
  rig.softened_overlap = softened_overlap_of_flow;
  const double impact = std::max(std::sqrt(rig.gravity * particle.length), std::abs(rate) * radius);
  settle_poured_bed(impact, rig);
  const double spin_up = rate == 0.0 ? 0.0 : spin_up_angle / std::abs(rate);
  rig.scene.phases.push_back({.name = "spin_up", .duration = spin_up, .fastest_impact = impact});
  rig.scene.phases.push_back({.name = "run", .fastest_impact = impact});
  rig.begins_from = BeginsFrom::filling;
  // 3. What is seen
  tell_what_is_seen(radius, share, rate, rig.seen_outline.emplace());
  rig.observables = {"drum_surface"};
  rig.complement = "the heap of the same grains that a lifted tube leaves (rig lifted_cylinder)";
}

}  // namespace

extern constinit const RigKind rotating_drum{
    .name = "rotating_drum",
    .meaning = "grains in a short drum that turns steadily, in three dimensions",
    .is_one_layer = false,
    .pours_a_bed = true,
    .read = read};

}  // namespace graintruth::datasets
