// An upright box of three dimensions that runs out through a slot in the middle of its floor. The
// slot goes from the front to the back; the origin is its middle, on the floor's upper face. It is
// closed until the start event.
#include <fmt/format.h>

#include <cmath>

#include "datasets/rigs/poured_bed.h"

namespace graintruth::datasets {

namespace {

constexpr double longest_settling = 3.0;  // s

// Level, from one x to the other.
SceneWall floor_part(std::string name, double from_x, double to_x, double depth) {
  const double y = 0.5 * depth;
  return flat_wall(std::move(name),
                   {{from_x, -y, 0.0}, {to_x, -y, 0.0}, {to_x, y, 0.0}, {from_x, y, 0.0}});
}

SceneWall side(std::string name, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double z) {
  const Eigen::Vector3d up(0.0, 0.0, z);
  return flat_wall(std::move(name), {from, to, to + up, from + up});
}

// Grains that are dropped from a lattice above each other need room: the box goes on upwards.
double room_for(const Particle& particle, double width, double depth) {
  const double cell = 1.1 * particle.length;
  const double columns = std::floor(width / cell) * std::floor(depth / cell);
  return columns < 1.0 ? 0.0 : std::ceil(particle.count / columns) * cell;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  TomlSection& keys = section.rig();
  const double width = keys.quantity("box_width", length_units, positive);
  const double depth = keys.quantity("box_depth", length_units, positive);
  const double height = keys.quantity("box_height", length_units, positive);
  const double slot = section.setting("slot_width", length_units, positive, rig).value_or(0.0);
  if (slot >= width) {
    section.fail(
        "slot_width",
        length_units,
        fmt::format("is {:.4g} mm, but the box is only {:.4g} mm wide", 1e3 * slot, 1e3 * width));
  }
  const double filled = room_for(*context.particle, width, depth);
  if (!(filled > 0.0)) {
    keys.fail(keys.key_of("box_width", length_units),
              fmt::format("makes a box in which no grain of {:.4g} mm has room",
                          1e3 * context.particle->length));
  }
  if (slot > 0.0)
    require_passage(section, "slot_width", slot, *context.particle, Passage::in_three_dimensions);
  const double x = 0.5 * width, y = 0.5 * depth, edge = 0.5 * slot, top = std::max(height, filled);
  rig.scene.walls = {side("left", {-x, -y, 0.0}, {-x, y, 0.0}, top),
                     side("right", {x, -y, 0.0}, {x, y, 0.0}, top),
                     side("front", {-x, -y, 0.0}, {x, -y, 0.0}, top),
                     side("back", {-x, y, 0.0}, {x, y, 0.0}, top),
                     floor_part("floor_left", -x, -edge, depth),
                     floor_part("floor_right", edge, x, depth)};
  if (slot > 0.0) {
    rig.scene.walls.push_back(floor_part("gate", -edge, edge, depth));
    rig.scene.walls.back().opens_at = 0.0;
  }
  rig.scene.exit_height = -context.particle->length;
  rig.scene.fill = {.method = SceneFill::Method::lattice,
                    .low = {-x, -y, 0.0},
                    .high = {x, y, top},
                    .clearance = 0.02 * context.particle->length};
  rig.softened_overlap = softened_overlap_of_flow;
  // The hardest expected impact is a fall by the width of the slot
  const double impact = std::sqrt(2.0 * rig.gravity * std::max(slot, context.particle->length));
  rig.scene.phases = {{.name = "settle",
                       .duration = longest_settling,
                       .until_rest = true,
                       .fastest_impact = impact},
                      {.name = "run", .fastest_impact = impact}};
  rig.scene.event_phase = 1;
  rig.begins_from = BeginsFrom::filling;
  rig.observables = {"discharge_rate", "what_stays"};
}

}  // namespace

extern constinit const RigKind box_silo{
    .name = "box_silo",
    .meaning = "an upright box that runs out through a slot in its floor, in three dimensions",
    .is_one_layer = false,
    .read = read};

}  // namespace graintruth::datasets
