// LAMMPS as an engine, for grains of one sphere between planes: Hertz, Mindlin and Tsuji's dashpot
// of pair_style granular, whose restitution is inverted first; exactly one `run`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/engines/engine_laws.h"
#include "calibrate/engines/granular_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using sim::Vec3;

// LAMMPS damps less than it is asked to.
double restitution_to_ask_of_lammps(double wanted) {
  const auto asked = restitution_to_ask([](double e) { return lammps_rebound(e, 1); }, wanted);
  if (asked) return *asked;
  throw datasets::InputError(fmt::format(
      "LAMMPS takes no restitution by which a contact rebounds by {}; use the engine 'embedded'.",
      wanted));
}

// How far a wall has moved along an axis, as a formula of LAMMPS: nothing before it starts, and far
// away once it has opened.
std::string displacement(const datasets::SceneWall& wall, int axis, double event, double dt) {
  constexpr double away = 1e3;  // m
  const std::string time = fmt::format("(step*{}-{})", digits(dt), digits(event));
  const datasets::SceneMotion& motion = wall.motion;
  std::string formula = "0";
  if (const double speed = motion.velocity[axis]; speed != 0.0) {
    const std::string start = digits(motion.start);
    formula = std::isfinite(motion.end)
                  ? fmt::format("({0}*(({1}>={2})*({1}<{3})*({1}-{2})+({1}>={3})*{4}))",
                                digits(speed),
                                time,
                                start,
                                digits(motion.end),
                                digits(motion.end - motion.start))
                  : fmt::format("({0}*({1}>={2})*({1}-{2}))", digits(speed), time, start);
  }
  if (std::isfinite(wall.opens_at))
    formula += fmt::format("+({}>={})*{}",
                           time,
                           digits(wall.opens_at),
                           digits(-away * wall.normal.normalized()[axis]));
  return formula;
}

Deck lammps_deck(const SimulationSpec& spec, const DeckScene& scene) {
  const sim::Scene& started = scene.built.scene;
  double bounding = 0.0;
  for (const sim::Clump& grain : started.types)
    bounding = std::max(bounding, grain.bounding_radius);
  const int grain = spec.scene.particles.front().material;
  const datasets::SceneMaterial& material = spec.scene.materials[static_cast<std::size_t>(grain)];
  const double modulus = material.elastic_modulus, nu = material.poisson_ratio;
  const sim::Surfaces between = surfaces_of(spec, grain, grain);
  const double skin = neighbour_skin(started);
  // 1. The bed
  std::string text =
      "units si\nnewton off\natom_style sphere\natom_modify map array\nboundary m m m\n";
  text += "read_data start.data\nneigh_modify delay 0\n";
  text += fmt::format("comm_modify vel yes cutoff {}\nneighbor {} bin\n",
                      digits(2.0 * bounding + skin),
                      digits(skin));
  // 2. Contacts
  text += fmt::format(
      "pair_style granular\npair_coeff * * hertz/material {} {} {} tangential mindlin NULL {} {} "
      "damping tsuji\n",
      digits(modulus),
      digits(restitution_to_ask_of_lammps(between.restitution)),
      digits(nu),
      digits(spec.scene.law.tangential_damping),
      digits(between.friction));
  // A wall is mixed with itself, by another formula than particles; these moduli make it rigid
  const double wall_modulus = 2.0 * modulus / (1.0 + nu);
  const double wall_tangential = 4.0 * modulus / ((2.0 - nu) * (1.0 + nu));
  const double event = static_cast<double>(scene.first_frame) *
                       static_cast<double>(scene.steps_a_frame) * scene.time_step;
  for (std::size_t w = 0; w < spec.scene.walls.size(); ++w) {
    const datasets::SceneWall& wall = spec.scene.walls[w];
    const sim::Surfaces surfaces = surfaces_of(spec, grain, wall.material);
    const bool moves = !wall.motion.velocity.isZero(0.0) || std::isfinite(wall.opens_at);
    std::string move;
    if (moves) {
      for (int axis = 0; axis < 3; ++axis)
        text += fmt::format("variable w{}{} equal {}\n",
                            w,
                            "xyz"[axis],
                            displacement(wall, axis, event, scene.time_step));
      move = fmt::format(" move v_w{0}x v_w{0}y v_w{0}z", w);
    }
    text += fmt::format("region w{} plane {} {}{}\n",
                        w,
                        digits(wall.points.front()),
                        digits(wall.normal.normalized()),
                        move);
    text += fmt::format(
        "fix w{0} all wall/gran/region granular hertz/material {1} {2} {3} tangential mindlin {4} "
        "{5} {6} damping tsuji region w{0}\n",
        w,
        digits(wall_modulus),
        digits(restitution_to_ask_of_lammps(surfaces.restitution)),
        digits(nu),
        digits(wall_tangential),
        digits(spec.scene.law.tangential_damping),
        digits(surfaces.friction));
  }
  // 3. Motion and frames
  text += weight(spec) + "fix motion all nve/sphere\n";
  text += fmt::format(
      "dump frames all custom {} frames.txt id x y z\ndump_modify frames format line \"%d %.17g "
      "%.17g %.17g\"\n",
      scene.steps_a_frame);
  text += fmt::format(
      "timestep {}\nthermo {}\nthermo_style custom step atoms\nthermo_modify lost error\n",
      digits(scene.time_step),
      std::max(1L, scene.steps / 10));
  // One only: at every further `run` LAMMPS converts the restitution of a wall once more
  text += fmt::format("run {}\n", scene.steps);
  return {.files = {{"deck.in", text}, {"start.data", start_data(started, 1)}}, .deck = "deck.in"};
}

class Lammps final : public GranularProgram {
 public:
  Lammps() : GranularProgram("lammps", "lmp", "lammps", "1") {}

 protected:
  Deck deck_of(const SimulationSpec& spec, const DeckScene& scene) const override {
    return lammps_deck(spec, scene);
  }
};

}  // namespace

const Engine& lammps_engine() {
  static const Lammps engine;
  return engine;
}

}  // namespace graintruth::calibrate
