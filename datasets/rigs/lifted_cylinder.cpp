// A tube full of grains that stands on a plate and is lifted straight up: the grains run out below
// it and stay as a heap. The origin is the tube's axis, on the plate's upper face; the picture
// plane goes through the axis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/rigs/poured_bed.h"

namespace graintruth::datasets {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double frame_interval = 0.02;                 // s
constexpr double longest_rest = 5.0;                    // s, after the tube is clear of the heap
constexpr double flattest = 10.0 * radians_per_degree;  // that dry grains stay
constexpr double steepest = 45.0 * radians_per_degree;

SceneWall shell(std::string name, double radius, double height, double speed) {
  SceneWall wall;
  wall.name = std::move(name);
  wall.material = wall_material;
  wall.kind = SceneWall::Kind::cylinder;
  wall.points = {Eigen::Vector3d::Zero(), {0.0, 0.0, height}};
  wall.radius = radius;
  wall.motion.velocity = {0.0, 0.0, speed};
  wall.body = "tube";
  return wall;
}

// Sites of one layer of a lattice on which a grain lies inside the tube.
long sites_in(double radius, double pitch) {
  const auto side = static_cast<long>(std::floor(2.0 * radius / pitch + 1e-9));
  long sites = 0;
  for (long i = 0; i < side; ++i) {
    for (long j = 0; j < side; ++j) {
      const double x = (static_cast<double>(i) + 0.5) * pitch - radius;
      const double y = (static_cast<double>(j) + 0.5) * pitch - radius;
      if (std::hypot(x, y) <= radius - 0.5 * pitch) ++sites;
    }
  }
  return sites;
}

// A cone of this volume and slope: V = pi R^3 tan / 3.
double foot_of_cone(double volume, double slope) {
  return std::cbrt(3.0 * volume / (pi * std::tan(slope)));
}

// Where the heap is looked for.
SeenOutline seen_outline(double volume, double outer, double height, double level, double speed) {
  const double reach = foot_of_cone(volume, flattest);
  const double low = 0.5 * reach * std::tan(flattest);  // half of the lowest heap
  const double inner = 0.25 * foot_of_cone(volume, steepest);
  SeenOutline seen;
  seen.from_x = -reach;
  seen.to_x = reach;
  seen.grains_after = {{{-inner, 0.0}, {inner, 0.0}, {inner, low}, {-inner, low}}};
  seen.empty = {{{-reach, level}, {reach, level}, {reach, 1.5 * level}, {-reach, 1.5 * level}}};
  seen.mover = SeenOutline::Mover{
      .name = "tube",
      .drawing = {{-outer, 0.0}, {outer, 0.0}, {outer, height}, {-outer, height}},
      .velocity = {0.0, speed},
      .speed_is_stated = speed > 0.0,
      .radius = outer};
  return seen;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  const Particle& particle = *context.particle;
  TomlSection& keys = section.rig();
  // 1. The tube and its filling
  const double radius = 0.5 * keys.quantity("tube_inner_diameter", length_units, positive);
  const double thickness = keys.quantity("tube_wall", length_units, positive);
  const double height = keys.quantity("tube_height", length_units, positive);
  const double speed = section.setting("lift_speed", speed_units, positive, rig).value_or(0.0);
  const double narrowest = narrowest_width(particle, Passage::in_three_dimensions);
  if (thickness >= 0.5 * narrowest) {
    keys.fail(
        keys.key_of("tube_wall", length_units),
        fmt::format("is {:.4g} mm, but the rim of the simulated tube is open: grains of {:.4g} "
                    "mm stay out of it only where it is thinner than half of that",
                    1e3 * thickness,
                    1e3 * narrowest));
  }
  const double pitch = lattice_pitch(particle, LatticeKind::loose);
  const long sites = sites_in(radius, pitch);
  if (sites == 0) {
    keys.fail(keys.key_of("tube_inner_diameter", length_units),
              fmt::format("is {:.4g} mm, in which no grain of {:.4g} mm has room",
                          2e3 * radius,
                          1e3 * particle.length));
  }
  const double area = pi * radius * radius;
  const int count = poured_count(
      section, context, [&](double level) { return area * level; }, rig);
  const double level = poured_height(particle, count, area);
  if (level > height) {
    keys.fail(keys.key_of("tube_height", length_units),
              fmt::format("is {:.4g} mm, but {} grains stand about {:.4g} mm high in it",
                          1e3 * height,
                          count,
                          1e3 * level));
  }
  // 2. Walls; grains that come down from a lattice need a longer tube
  const double layers = std::ceil(static_cast<double>(count) / static_cast<double>(sites));
  const double top = std::max(height, (layers + 1.0) * pitch);
  rig.scene.fill = filling_from_lattice(
      particle,
      LatticeKind::loose,
      {-radius, -radius, 0.0},
      {radius, radius, top},
      SceneRoom{.from = Eigen::Vector3d::Zero(), .to = {0.0, 0.0, top}, .radius = radius});
  SceneWall plate;
  plate.name = "plate";
  plate.material = wall_material;
  plate.points = {Eigen::Vector3d::Zero()};
  rig.scene.walls = {plate,
                     shell("tube_inside", radius, top, speed),
                     shell("tube_outside", radius + thickness, top, speed)};
  // 3. Phases. A grain comes down a slope from grain to grain, half a diameter at a time
  rig.softened_overlap = softened_overlap_of_flow;
  const double impact = std::max(std::sqrt(rig.gravity * particle.length), speed);
  settle_poured_bed(impact, rig);
  // The tube touches the heap no more when its rim is above it. A cone of slope t and volume V is
  // (3 V t^2/pi)^(1/3) - R t high at the radius R of the tube; over all slopes this is at most 4/9
  // of the level of V in the tube.
  const double clear = speed > 0.0 ? 4.0 / 9.0 * level / speed : 0.0;
  release_poured_bed(
      {.phase = "lift", .lasts = clear, .rests_at_most = longest_rest, .interval = frame_interval},
      impact,
      rig);
  rig.begins_from = BeginsFrom::filling;
  rig.seen_outline = seen_outline(level * area, radius + thickness, height, level, speed);
  rig.observables = {"free_surface"};
  rig.complement =
      "a drum half full of the same grains that turns slowly, at several speeds (rig "
      "rotating_drum)";
}

}  // namespace

extern constinit const RigKind lifted_cylinder{
    .name = "lifted_cylinder",
    .meaning = "a heap left by a tube of grains that is lifted off a plate, in three dimensions",
    .is_one_layer = false,
    .pours_a_bed = true,
    .read = read};

}  // namespace graintruth::datasets
