// A column of grains against the left end of a tank that runs out when the gate beside it is pulled
// up. The origin is the tank's left lower corner, in the inner face of the front pane.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/rigs/poured_bed.h"

namespace graintruth::datasets {

namespace {

constexpr double frame_interval = 0.01;  // s
constexpr double longest_rest = 2.0;     // s
// In falling times of the column, sqrt(2 H/g): by then its front has come to rest (Lube et al. 2004
// find 2.3 to 3.3)
constexpr double running = 3.3;
constexpr double surely_full = 0.8;  // of the level

SceneWall flat(std::string name, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  SceneWall wall;
  wall.name = std::move(name);
  wall.material = wall_material;
  wall.kind = SceneWall::Kind::plane;
  wall.points = {point};
  wall.normal = normal;
  return wall;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  const Particle& particle = *context.particle;
  TomlSection& keys = section.rig();
  const double length = keys.quantity("tank_length", length_units, positive);
  const double depth = keys.quantity("tank_depth", length_units, positive);
  const double width = keys.quantity("column_width", length_units, positive);
  const double speed = section.setting("gate_speed", speed_units, positive, rig).value_or(0.0);
  if (width >= length) {
    keys.fail(keys.key_of("column_width", length_units),
              fmt::format(
                  "is {:.4g} mm, but the tank is only {:.4g} mm long", 1e3 * width, 1e3 * length));
  }
  const double pitch = lattice_pitch(particle, LatticeKind::loose);
  const double sites = std::floor(width / pitch + 1e-9) * std::floor(depth / pitch + 1e-9);
  if (sites < 1.0) {
    const bool is_narrow = width < pitch;
    keys.fail(
        keys.key_of(is_narrow ? "column_width" : "tank_depth", length_units),
        fmt::format("leaves no room in the column for a grain of {:.4g} mm, which needs {:.4g} "
                    "mm to be poured in",
                    1e3 * particle.length,
                    1e3 * pitch));
  }
  // 1. The filling
  const double area = width * depth;
  const int count = poured_count(
      section, context, [&](double level) { return area * level; }, rig);
  const double level = poured_height(particle, count, area);
  const double top = (std::ceil(count / sites) + 1.0) * pitch;
  rig.scene.fill = filling_from_lattice(
      particle, LatticeKind::loose, Eigen::Vector3d::Zero(), {width, depth, top}, std::nullopt);
  // 2. Walls
  SceneWall gate = flat_wall(
      "gate", {{width, 0.0, 0.0}, {width, depth, 0.0}, {width, depth, top}, {width, 0.0, top}});
  gate.motion.velocity = {0.0, 0.0, speed};
  rig.scene.walls = {flat("floor", Eigen::Vector3d::Zero(), {0.0, 0.0, 1.0}),
                     flat("end_left", Eigen::Vector3d::Zero(), {1.0, 0.0, 0.0}),
                     flat("end_right", {length, 0.0, 0.0}, {-1.0, 0.0, 0.0}),
                     flat("pane_front", Eigen::Vector3d::Zero(), {0.0, 1.0, 0.0}),
                     flat("pane_back", {0.0, depth, 0.0}, {0.0, -1.0, 0.0}),
                     gate};
  // 3. Phases. The top of the column falls by about half its height before it spreads
  rig.softened_overlap = softened_overlap_of_flow;
  const double impact = std::sqrt(rig.gravity * std::max(level, particle.length));
  settle_poured_bed(impact, rig);
  const double falling = running * std::sqrt(2.0 * level / rig.gravity);
  release_poured_bed({.phase = "collapse",
                      .lasts = falling,
                      .rests_at_most = longest_rest,
                      .interval = frame_interval},
                     impact,
                     rig);
  rig.begins_from = BeginsFrom::filling;
  // 4. What is seen
  SeenOutline& seen = rig.seen_outline.emplace();
  seen.to_x = length;
  const double full = surely_full * level;
  seen.grains_before = {{{0.0, 0.0}, {width, 0.0}, {width, full}, {0.0, full}}};
  const double over = highest_level(particle, level, depth);
  const double above = over + 0.3 * level;
  seen.empty = {{{0.0, over}, {length, over}, {length, above}, {0.0, above}}};
  seen.mover = SeenOutline::Mover{.name = "gate",
                                  .drawing = {{width, 0.0}, {width, level}},
                                  .velocity = {0.0, speed},
                                  .speed_is_stated = speed > 0.0};
  rig.observables = {"free_surface", "run_out"};
  rig.complement = "the heap of the same grains that a lifted tube leaves (rig lifted_cylinder)";
}

}  // namespace

extern constinit const RigKind column_collapse{
    .name = "column_collapse",
    .meaning = "a column of grains that runs out when a gate is pulled up, in three dimensions",
    .is_one_layer = false,
    .pours_a_bed = true,
    .read = read};

}  // namespace graintruth::datasets
