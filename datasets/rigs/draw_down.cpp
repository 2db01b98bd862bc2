// A box of grains above another one. A slide below the slot in the floor of the upper box is pulled
// aside; grains run down until what stays above leans against the walls of the upper box and what
// came down lies as a heap in the lower box. The origin is the middle of the slot, on the upper
// face of the shelf in which it is, in the inner face of the front pane.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/rigs/poured_bed.h"

namespace graintruth::datasets {

namespace {

constexpr double frame_interval = 0.02;                 // s
constexpr double surely_full = 0.8;                     // of the level
constexpr double flattest = 10.0 * radians_per_degree;  // that dry grains stay

struct Boxes {
  double upper_width = 0.0, upper_height = 0.0;  // m
  double slot = 0.0, shelf = 0.0;                // m, width of the slot and thickness of its shelf
  double fall = 0.0;                             // m, from the upper face of the shelf to the floor
  double lower_width = 0.0, depth = 0.0;         // m
  double gate_length = 0.0, gate_thickness = 0.0;  // m
  double gate_speed = 0.0;                         // m/s, to the right
};

// An upright or level wall from front to back.
SceneWall sheet(const std::string& name, double depth, double x0, double z0, double x1, double z1) {
  return flat_wall(name, {{x0, 0.0, z0}, {x0, depth, z0}, {x1, depth, z1}, {x1, 0.0, z1}});
}

SceneWall plane(const std::string& name, double y, double z, const Eigen::Vector3d& normal) {
  SceneWall wall;
  wall.name = name;
  wall.material = wall_material;
  wall.kind = SceneWall::Kind::plane;
  wall.points = {{0.0, y, z}};
  wall.normal = normal;
  return wall;
}

// The slide reaches from one edge of the slot, which is open when it has gone by the slot's width,
// past the other.
std::vector<SceneWall> walls_of(const Boxes& boxes, double top) {
  const double upper = 0.5 * boxes.upper_width, lower = 0.5 * boxes.lower_width;
  const double edge = 0.5 * boxes.slot, below = -boxes.shelf, floor = -boxes.fall;
  const double aside = boxes.gate_speed < 0.0 ? -1.0 : 1.0;
  const auto sheet_of = [&](const char* name, double x0, double z0, double x1, double z1) {
    return sheet(name, boxes.depth, x0, z0, x1, z1);
  };
  std::vector<SceneWall> walls = {
      plane("pane_front", 0.0, 0.0, {0.0, 1.0, 0.0}),
      plane("pane_back", boxes.depth, 0.0, {0.0, -1.0, 0.0}),
      plane("floor", 0.0, floor, {0.0, 0.0, 1.0}),
      sheet_of("upper_left", -upper, 0.0, -upper, top),
      sheet_of("upper_right", upper, 0.0, upper, top),
      sheet_of("shelf_left", -upper, 0.0, -edge, 0.0),
      sheet_of("shelf_right", edge, 0.0, upper, 0.0),
      sheet_of("shelf_left_edge", -edge, below, -edge, 0.0),
      sheet_of("shelf_right_edge", edge, below, edge, 0.0),
      sheet_of("lower_left", -lower, floor, -lower, below),
      sheet_of("lower_right", lower, floor, lower, below),
      sheet_of("gate", -aside * edge, below, aside * (boxes.gate_length - edge), below)};
  walls[5].body = walls[7].body = "shelf_left";
  walls[6].body = walls[8].body = "shelf_right";
  SceneMotion& motion = walls.back().motion;
  motion.velocity = {boxes.gate_speed, 0.0, 0.0};
  if (boxes.gate_speed != 0.0) motion.end = boxes.slot / std::abs(boxes.gate_speed);
  return walls;
}

// Where both beds are looked for. `over`: no grain lies so high.
SeenOutline seen_outline(const Boxes& boxes, double level, double over, double grain) {
  const double upper = 0.5 * boxes.upper_width, lower = 0.5 * boxes.lower_width;
  const double edge = 0.5 * boxes.slot, floor = -boxes.fall;
  const double aside = boxes.gate_speed < 0.0 ? -1.0 : 1.0;
  const double gate_from = -aside * edge, gate_to = aside * (boxes.gate_length - edge);
  SeenOutline seen;
  // The slide is watched until it has opened the slot, and a little longer
  const double reach = std::max({upper, lower, boxes.gate_length + boxes.slot});
  seen.from_x = aside < 0.0 ? -reach : -std::max(upper, lower);
  seen.to_x = aside < 0.0 ? std::max(upper, lower) : reach;
  seen.floor_z = floor;
  seen.surfaces = {{.name = "upper", .from_x = -upper, .to_x = upper, .floor_z = 0.0},
                   {.name = "lower",
                    .from_x = -lower,
                    .to_x = lower,
                    .floor_z = floor,
                    .top_z = -boxes.shelf - boxes.gate_thickness}};
  const double full = surely_full * level;
  seen.grains_before = {{{-upper, 0.0}, {upper, 0.0}, {upper, full}, {-upper, full}}};
  // At least what stood above the slot comes down; of the lowest heap half, and a quarter of the
  // steepest one's width
  const double area = boxes.slot * level;
  const double low = 0.5 * std::sqrt(area * std::tan(flattest));
  const double inner = 0.25 * std::sqrt(area);
  seen.grains_after = {
      {{-inner, floor}, {inner, floor}, {inner, floor + low}, {-inner, floor + low}}};
  // At most the bed slopes from wall to slot as flatly as grains may
  const double half = upper - edge;
  const double stays = std::min(0.5 * half * std::tan(flattest), full);
  if (stays > grain) {
    for (const double side : {-1.0, 1.0})
      seen.grains_after.push_back({{side * upper, 0.0},
                                   {side * (upper - 0.25 * half), 0.0},
                                   {side * (upper - 0.25 * half), stays},
                                   {side * upper, stays}});
  }
  const double highest = over + 0.3 * level + grain;
  seen.empty = {{{-upper, over}, {upper, over}, {upper, highest}, {-upper, highest}}};
  const double gate_top = -boxes.shelf, gate_bottom = gate_top - boxes.gate_thickness;
  seen.mover = SeenOutline::Mover{.name = "slide",
                                  .drawing = {{gate_from, gate_bottom},
                                              {gate_to, gate_bottom},
                                              {gate_to, gate_top},
                                              {gate_from, gate_top}},
                                  .velocity = {boxes.gate_speed, 0.0},
                                  .speed_is_stated = boxes.gate_speed != 0.0};
  return seen;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  const Particle& particle = *context.particle;
  TomlSection& keys = section.rig();
  // 1. Both boxes
  Boxes boxes;
  const auto fail = [&](const char* stem, const std::string& complaint) {
    keys.fail(keys.key_of(stem, length_units), complaint);
  };
  boxes.upper_width = keys.quantity("upper_width", length_units, positive);
  boxes.upper_height = keys.quantity("upper_height", length_units, positive);
  boxes.slot = keys.quantity("slot_width", length_units, positive);
  boxes.shelf = keys.quantity("shelf_thickness", length_units, positive);
  boxes.fall = keys.quantity("fall_height", length_units, positive);
  boxes.lower_width = keys.quantity("lower_width", length_units, positive);
  boxes.depth = keys.quantity("box_depth", length_units, positive);
  boxes.gate_length = keys.quantity("gate_length", length_units, positive);
  boxes.gate_thickness = keys.quantity("gate_thickness", length_units, positive);
  boxes.gate_speed = section.setting("gate_speed", speed_units, any_number, rig).value_or(0.0);
  if (!rig.settings.empty() && boxes.gate_speed == 0.0)
    section.fail("gate_speed",
                 speed_units,
                 "is 0, but the slide is pulled aside; to the left its speed is below 0");
  require_passage(section, "slot_width", boxes.slot, particle, Passage::in_three_dimensions);
  if (boxes.slot >= boxes.upper_width) {
    fail("slot_width",
         fmt::format("is {:.4g} mm, but the upper box is only {:.4g} mm wide",
                     1e3 * boxes.slot,
                     1e3 * boxes.upper_width));
  }
  if (boxes.gate_length < boxes.slot) {
    fail("gate_length",
         fmt::format("is {:.4g} mm, but the slot that the slide closes is {:.4g} mm wide",
                     1e3 * boxes.gate_length,
                     1e3 * boxes.slot));
  }
  if (boxes.shelf + boxes.gate_thickness >= boxes.fall) {
    fail("fall_height",
         fmt::format("is {:.4g} mm, but shelf and slide alone are {:.4g} mm thick",
                     1e3 * boxes.fall,
                     1e3 * (boxes.shelf + boxes.gate_thickness)));
  }
  const double pitch = lattice_pitch(particle, LatticeKind::loose);
  const double sites =
      std::floor(boxes.upper_width / pitch + 1e-9) * std::floor(boxes.depth / pitch + 1e-9);
  if (sites < 1.0) {
    fail(boxes.depth < pitch ? "box_depth" : "upper_width",
         fmt::format("leaves no room for a grain of {:.4g} mm, which needs {:.4g} mm to be poured "
                     "in",
                     1e3 * particle.length,
                     1e3 * pitch));
  }
  // 2. The filling
  const double area = boxes.upper_width * boxes.depth;
  const int count = poured_count(
      section, context, [&](double level) { return area * level; }, rig);
  const double level = poured_height(particle, count, area);
  if (level > boxes.upper_height) {
    fail("upper_height",
         fmt::format("is {:.4g} mm, but {} grains stand about {:.4g} mm high in the upper box",
                     1e3 * boxes.upper_height,
                     count,
                     1e3 * level));
  }
  if (boxes.upper_width * level >
      boxes.lower_width * (boxes.fall - boxes.shelf - boxes.gate_thickness)) {
    fail("lower_width",
         fmt::format("is {:.4g} mm: the lower box has less room than {} grains take",
                     1e3 * boxes.lower_width,
                     count));
  }
  const double top = std::max(boxes.upper_height, (std::ceil(count / sites) + 1.0) * pitch);
  const double half = 0.5 * boxes.upper_width;
  rig.scene.fill = filling_from_lattice(
      particle, LatticeKind::loose, {-half, 0.0, 0.0}, {half, boxes.depth, top}, std::nullopt);
  rig.scene.walls = walls_of(boxes, top);
  // 3. Phases. Grains fall from the slot to the floor; the bed runs out for some three times as
  // long as the rate through a wide slot tells (Beverloo et al. 1961 for slots: 1.03 rho sqrt(g)
  // depth (width - 1.4 d)^1.5)
  rig.softened_overlap = softened_overlap_of_flow;
  const double impact = std::sqrt(2.0 * rig.gravity * boxes.fall);
  settle_poured_bed(impact, rig);
  const double clear = std::max(boxes.slot - 1.4 * particle.diameter, 0.25 * particle.diameter);
  const double emptying =
      boxes.upper_width * level / (1.03 * std::sqrt(rig.gravity) * clear * std::sqrt(clear));
  const double opening = boxes.gate_speed != 0.0 ? boxes.slot / std::abs(boxes.gate_speed) : 0.0;
  release_poured_bed({.phase = "open",
                      .lasts = opening + std::sqrt(2.0 * (level + boxes.fall) / rig.gravity),
                      .rests_at_most = 2.0 + 3.0 * emptying,
                      .interval = frame_interval},
                     impact,
                     rig);
  rig.begins_from = BeginsFrom::filling;
  rig.seen_outline =
      seen_outline(boxes, level, highest_level(particle, level, boxes.depth), particle.diameter);
  rig.observables = {"free_surface_upper", "free_surface_lower"};
  rig.complement =
      "a drum half full of the same grains that turns slowly, at several speeds (rig "
      "rotating_drum)";
}

}  // namespace

extern constinit const RigKind draw_down{
    .name = "draw_down",
    .meaning = "a box of grains that runs through a slot into a box below, in three dimensions",
    .is_one_layer = false,
    .pours_a_bed = true,
    .read = read};

}  // namespace graintruth::datasets
