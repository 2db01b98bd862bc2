// An upright bin with a flat floor and an orifice in its middle, closed until the start event. The
// origin is the middle of the orifice on the floor's upper face.
#include <fmt/format.h>

#include <cmath>

#include "datasets/rigs/followed_grains.h"
#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

namespace {

constexpr double settling_time = 0.1;  // s of rest on the closed orifice

// Side walls, and the floor left and right of the orifice.
std::vector<Wall> walls_of(double width, double height, double orifice) {
  const double side = 0.5 * width, edge = 0.5 * orifice;
  std::vector<Wall> walls = {{"side_left", -side, 0.0, -side, height},
                             {"side_right", side, 0.0, side, height}};
  if (edge < side) {
    walls.push_back({"floor_left", -side, 0.0, -edge, 0.0});
    walls.push_back({"floor_right", edge, 0.0, side, 0.0});
  }
  return walls;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  TomlSection& keys = section.rig();
  const double width = keys.quantity("bin_width", length_units, positive);
  const double height = keys.quantity("bin_height", length_units, positive);
  const double orifice =
      section.setting("orifice_width", length_units, positive, rig).value_or(0.0);
  if (orifice > width) {
    section.fail(
        "orifice_width",
        length_units,
        fmt::format("is {:.4g} mm, wider than the bin of {:.4g} mm", 1e3 * orifice, 1e3 * width));
  }
  if (context.particle != nullptr && orifice > 0.0)
    require_passage(section, "orifice_width", orifice, *context.particle, Passage::in_one_layer);
  rig.walls = walls_of(width, height, orifice);
  rig.bed = {.left_x = -0.5 * width, .right_x = 0.5 * width, .height = height};
  if (orifice > 0.0) rig.opening = {.left_x = -0.5 * orifice, .right_x = 0.5 * orifice};
  // A camera sees no grain above the side walls' ends, but a measured bed may touch them
  for (const Wall& wall : rig.walls) {
    rig.scene.walls.push_back(segment_of(wall));
    if (wall.from_x == wall.to_x) rig.scene.walls.back().points[1].z() = 2.0 * wall.to_z;
  }
  SceneWall stopper = segment_of({"stopper", -0.5 * orifice, 0.0, 0.5 * orifice, 0.0});
  stopper.opens_at = 0.0;
  rig.scene.walls.push_back(std::move(stopper));
  rig.softened_overlap = softened_overlap_of_flow;
  rig.begins_from = BeginsFrom::each_replicate;
  rig.observables = {"discharge_rate", "what_stays", "velocity_profile"};
  // Where no film tells a bed: rows that fall and settle without friction (thesis 4.3.4)
  rig.scene.fill.method = SceneFill::Method::rows;
  rig.scene.fill.low.x() = -0.5 * width;
  rig.scene.fill.high.x() = 0.5 * width;
  // The hardest expected impact is a fall by the width of the orifice
  const double impact = std::sqrt(2.0 * rig.gravity * orifice);
  rig.scene.phases = {{.name = "settle",
                       .duration = settling_time,
                       .fastest_impact = impact,
                       .restitution_at_most = settling_restitution},
                      {.name = "run", .fastest_impact = impact}};
  rig.scene.event_phase = 1;
}

}  // namespace

extern constinit const RigKind flat_bin_orifice{
    .name = "flat_bin_orifice",
    .meaning = "an upright bin of one layer that runs out through an orifice in its floor",
    .template_name = "macro",
    .read = read};

}  // namespace graintruth::datasets
