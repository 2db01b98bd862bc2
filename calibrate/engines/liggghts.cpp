// LIGGGHTS as an engine, for grains of one sphere between planes along the axes: Hertz and Mindlin
// as its `model hertz tangential history`. One contact rebounds as asked; a clump would rebound by
// e^(root of n) with n contacts at once, so clumps are refused.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/engines/granular_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using sim::Vec3;

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

Deck liggghts_deck(const SimulationSpec& spec, const DeckScene& scene) {
  const sim::Scene& started = scene.built.scene;
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
      digits(neighbour_skin(started)));
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
  text += weight(spec) + "fix motion all nve/sphere\n";
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

class Liggghts final : public GranularProgram {
 public:
  Liggghts() : GranularProgram("liggghts", "liggghts", "liggghts", "1") {}

 protected:
  Deck deck_of(const SimulationSpec& spec, const DeckScene& scene) const override {
    return liggghts_deck(spec, scene);
  }
};

}  // namespace

const Engine& liggghts_engine() {
  static const Liggghts engine;
  return engine;
}

}  // namespace graintruth::calibrate
