// LIGGGHTS as an engine, for grains of one sphere between planes along the axes: Hertz and Mindlin
// as its `model hertz tangential history`. One contact rebounds as asked; a clump would rebound by
// e^(root of n) with n contacts at once, so clumps are refused.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibrate/engines/embedded.h"
#include "calibrate/engines/granular_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using sim::Vec3;

constexpr const char* deck_version = "1";   // changes whenever the deck gives other numbers
constexpr double least_restitution = 0.05;  // LIGGGHTS stops with an error there
constexpr double stiffer = 1e6;             // a wall, than the grains: as good as rigid

[[noreturn]] void refuse(const std::string& what) {
  throw datasets::InputError(fmt::format(
      "the engine 'liggghts' cannot simulate this scene: {}; use the engine 'lammps' or "
      "'embedded'.",
      what));
}

// The axis that a wall stands upright on.
int axis_of(const datasets::SceneWall& wall) {
  const Vec3 normal = wall.normal.normalized();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(std::abs(normal[axis]) - 1.0) < 1e-12) return axis;
  }
  refuse(fmt::format("the wall '{}' does not stand along an axis", wall.name));
}

std::string start_data(const sim::Scene& scene, std::size_t types) {
  std::string atoms, speeds;
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const sim::Body& body = scene.bodies[b];
    const sim::Clump& grain = scene.types[static_cast<std::size_t>(body.type)];
    const double radius = grain.spheres.front().radius;
    const Vec3& p = body.position;
    const Vec3& v = body.velocity;
    const Vec3& w = body.angular_velocity;
    atoms += fmt::format("{} 1 {} {} {} {} {}\n",
                         b + 1,
                         digits(2.0 * radius),
                         digits(grain.mass / grain.volume),
                         digits(p.x()),
                         digits(p.y()),
                         digits(p.z()));
    speeds += fmt::format("{} {} {} {} {} {} {}\n",
                          b + 1,
                          digits(v.x()),
                          digits(v.y()),
                          digits(v.z()),
                          digits(w.x()),
                          digits(w.y()),
                          digits(w.z()));
    low = low.cwiseMin(p - Vec3::Constant(2.0 * radius));
    high = high.cwiseMax(p + Vec3::Constant(2.0 * radius));
  }
  std::string text =
      fmt::format("graintruth\n\n{} atoms\n{} atom types\n", scene.bodies.size(), types);
  for (int axis = 0; axis < 3; ++axis)
    text += fmt::format(
        "{} {} {}lo {}hi\n", digits(low[axis]), digits(high[axis]), "xyz"[axis], "xyz"[axis]);
  return text + "\nAtoms\n\n" + atoms + "\nVelocities\n\n" + speeds;
}

Deck deck_of(const SimulationSpec& spec, const DeckScene& scene) {
  const sim::Scene& started = scene.built.scene;
  double smallest = 1e300;
  for (const sim::Clump& grain : started.types) {
    if (grain.spheres.size() > 1) refuse("its grains are clumps of several spheres");
    smallest = std::min(smallest, grain.smallest_radius);
  }
  const int material = spec.scene.particles.front().material;
  const datasets::SceneMaterial& grain = spec.scene.materials[static_cast<std::size_t>(material)];
  // 1. Type 1 is the grains, each wall a type of its own
  const std::size_t types = 1 + spec.scene.walls.size();
  std::vector<sim::Surfaces> of_walls;
  for (const datasets::SceneWall& wall : spec.scene.walls) {
    if (!wall.motion.velocity.isZero(0.0) || std::isfinite(wall.opens_at))
      refuse(fmt::format("the wall '{}' moves or opens", wall.name));
    of_walls.push_back(surfaces_of(spec, material, wall.material));
  }
  const sim::Surfaces between = surfaces_of(spec, material, material);
  const auto table = [&](auto value) {
    std::string text;
    for (std::size_t i = 0; i < types; ++i) {
      for (std::size_t j = 0; j < types; ++j) {
        const bool with_wall = (i == 0) != (j == 0);
        text += " " + digits(value(with_wall ? of_walls[std::max(i, j) - 1] : between));
      }
    }
    return text;
  };
  for (const sim::Surfaces& surfaces : of_walls) {
    if (std::min(surfaces.restitution, between.restitution) <= least_restitution)
      refuse(fmt::format("it has a restitution of {} or less", least_restitution));
  }
  std::string moduli = digits(grain.elastic_modulus), ratios = digits(grain.poisson_ratio);
  for (std::size_t w = 1; w < types; ++w) {
    moduli += " " + digits(stiffer * grain.elastic_modulus);
    ratios += " " + digits(grain.poisson_ratio);
  }
  std::string text = fmt::format(
      "units si\nhard_particles yes\nsoft_particles yes\natom_style granular\n"
      "atom_modify map array sort 0 0\nboundary m m m\nnewton off\ncommunicate single vel yes\n"
      "read_data start.data\nneighbor {} bin\nneigh_modify delay 0\n",
      digits(0.2 * smallest));
  text +=
      fmt::format("fix youngs_modulus all property/global youngsModulus peratomtype {}\n", moduli);
  text +=
      fmt::format("fix poisson_ratio all property/global poissonsRatio peratomtype {}\n", ratios);
  text += fmt::format(
      "fix restitution all property/global coefficientRestitution peratomtypepair {}{}\n",
      types,
      table([](const sim::Surfaces& surfaces) { return surfaces.restitution; }));
  text += fmt::format("fix friction all property/global coefficientFriction peratomtypepair {}{}\n",
                      types,
                      table([](const sim::Surfaces& surfaces) { return surfaces.friction; }));
  text += "pair_style gran model hertz tangential history\npair_coeff * *\n";
  for (std::size_t w = 0; w < spec.scene.walls.size(); ++w) {
    const datasets::SceneWall& wall = spec.scene.walls[w];
    const int axis = axis_of(wall);
    text += fmt::format(
        "fix w{} all wall/gran model hertz tangential history primitive type {} {}plane {}\n",
        w,
        w + 2,
        "xyz"[axis],
        digits(wall.points.front()[axis]));
  }
  // 2. Motion and frames
  const double gravity = spec.scene.gravity.norm();
  const Vec3 down = gravity > 0.0 ? Vec3(spec.scene.gravity / gravity) : Vec3(0.0, 0.0, -1.0);
  text += fmt::format("fix weight all gravity {} vector {} {} {}\nfix motion all nve/sphere\n",
                      digits(gravity),
                      digits(down.x()),
                      digits(down.y()),
                      digits(down.z()));
  text += fmt::format(
      "dump frames all custom {} frames.txt id x y z\ndump_modify frames format \"%d %.17g %.17g "
      "%.17g\"\ntimestep {}\nthermo {}\nthermo_modify lost error norm no\nrun {}\n",
      scene.steps_a_frame,
      digits(scene.time_step),
      std::max(1L, scene.steps / 10),
      scene.steps);
  return {.files = {{"deck.in", text}, {"start.data", start_data(started, types)}},
          .deck = "deck.in"};
}

class Liggghts final : public Engine {
 public:
  std::string_view name() const override { return "liggghts"; }
  std::string version() const override {
    static const std::string version = version_of_program("liggghts", "liggghts");
    return fmt::format("{}, deck {}", version, deck_version);
  }
  bool is_another_program() const override { return true; }
  std::vector<std::string> curves(const SimulationSpec&) const override {
    return {"highest_grain_m"};
  }
  double largest_time_step_fraction(const SimulationSpec& spec) const override {
    return embedded_engine().largest_time_step_fraction(spec);
  }

  EngineRun run(const SimulationSpec& spec, const EngineOptions& options) const override {
    try {
      const DeckScene scene = deck_scene_of(spec, name());
      return run_deck(spec, options, scene, deck_of(spec, scene), "liggghts");
    } catch (const std::invalid_argument& error) {
      return {.status = RunStatus::unstable, .message = error.what()};
    }
  }
};

}  // namespace

const Engine& liggghts_engine() {
  static const Liggghts engine;
  return engine;
}

}  // namespace graintruth::calibrate
