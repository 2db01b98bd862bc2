// LAMMPS as an engine: every clump a rigid body of fix rigid/small, Hertz, Mindlin and Tsuji's
// dashpot of pair_style granular, whose restitution is inverted first; exactly one `run`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/engines/embedded.h"
#include "calibrate/engines/engine_laws.h"
#include "calibrate/engines/granular_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using sim::Body;
using sim::Clump;
using sim::Vec3;

constexpr const char* deck_version = "1";  // changes whenever the deck gives other numbers

// LAMMPS damps less than it is asked to.
double restitution_to_ask_of_lammps(double wanted) {
  const auto asked = restitution_to_ask([](double e) { return lammps_rebound(e, 1); }, wanted);
  if (asked) return *asked;
  throw datasets::InputError(fmt::format(
      "LAMMPS takes no restitution by which a contact rebounds by {}; use the engine 'embedded'.",
      wanted));
}

std::string vector_text(const Vec3& v) {
  return fmt::format("{} {} {}", digits(v.x()), digits(v.y()), digits(v.z()));
}

double volume_of_spheres(const Clump& clump) {
  double volume = 0.0;
  for (const sim::ElementSphere& sphere : clump.spheres)
    volume += 4.0 / 3.0 * 3.14159265358979323846 * sphere.radius * sphere.radius * sphere.radius;
  return volume;
}

// Atoms, their speeds, and of which body they are.
std::string start_data(const sim::Scene& scene, bool are_clumps) {
  std::string atoms, speeds, bodies;
  Vec3 low = Vec3::Constant(1e300), high = -low;
  std::size_t count = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const Clump& clump = scene.types[static_cast<std::size_t>(body.type)];
    const double density = clump.mass / volume_of_spheres(clump);
    // Neighbours are looked for in boxes of the cutoff, of which at least one must fit in
    const Vec3 margin = Vec3::Constant(4.0 * clump.bounding_radius);
    for (const sim::ElementSphere& sphere : clump.spheres) {
      const Vec3 lever = body.orientation * sphere.centre, centre = body.position + lever;
      const Vec3 speed = body.velocity + body.angular_velocity.cross(lever);
      ++count;
      atoms += fmt::format("{} 1 {} {} {}\n",
                           count,
                           digits(2.0 * sphere.radius),
                           digits(density),
                           vector_text(centre));
      speeds +=
          fmt::format("{} {} {}\n", count, vector_text(speed), vector_text(body.angular_velocity));
      bodies += fmt::format("{} {}\n", count, b + 1);
      low = low.cwiseMin(centre - margin);
      high = high.cwiseMax(centre + margin);
    }
  }
  std::string text = fmt::format("graintruth\n\n{} atoms\n1 atom types\n", count);
  for (int axis = 0; axis < 3; ++axis)
    text += fmt::format(
        "{} {} {}lo {}hi\n", digits(low[axis]), digits(high[axis]), "xyz"[axis], "xyz"[axis]);
  text += "\nAtoms # sphere\n\n" + atoms + "\nVelocities\n\n" + speeds;
  if (are_clumps) text += "\nMolecules\n\n" + bodies;
  return text;
}

// Mass, centre, inertia, velocity and angular momentum of every body, as fix rigid/small reads
// them.
std::string body_file(const sim::Scene& scene) {
  std::string text = fmt::format("{}\n", scene.bodies.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const Clump& clump = scene.types[static_cast<std::size_t>(body.type)];
    const sim::Mat3 turn = body.orientation.toRotationMatrix();
    const sim::Mat3 inertia = turn * clump.inertia.asDiagonal() * turn.transpose();
    text += fmt::format("{} {} {} {} {} {} {} {} {} {} {} 0 0 0\n",
                        b + 1,
                        digits(clump.mass),
                        vector_text(body.position),
                        digits(inertia(0, 0)),
                        digits(inertia(1, 1)),
                        digits(inertia(2, 2)),
                        digits(inertia(0, 1)),
                        digits(inertia(0, 2)),
                        digits(inertia(1, 2)),
                        vector_text(body.velocity),
                        vector_text(inertia * body.angular_velocity));
  }
  return text;
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

Deck deck_of(const SimulationSpec& spec, const DeckScene& scene) {
  const sim::Scene& started = scene.built.scene;
  const bool are_clumps = std::any_of(started.types.begin(),
                                      started.types.end(),
                                      [](const Clump& clump) { return clump.spheres.size() > 1; });
  double bounding = 0.0, smallest = 1e300;
  for (const Clump& clump : started.types) {
    bounding = std::max(bounding, clump.bounding_radius);
    smallest = std::min(smallest, clump.smallest_radius);
  }
  const int grain = spec.scene.particles.front().material;
  const datasets::SceneMaterial& material = spec.scene.materials[static_cast<std::size_t>(grain)];
  const double modulus = material.elastic_modulus, nu = material.poisson_ratio;
  const sim::Surfaces between = surfaces_of(spec, grain, grain);
  const double skin = 0.2 * smallest;
  // 1. The bed
  std::string text =
      "units si\nnewton off\natom_style sphere\natom_modify map array\nboundary m m m\n";
  text += are_clumps ? "fix particle_of all property/atom mol ghost yes\n"
                       "read_data start.data fix particle_of NULL Molecules\n"
                       "neigh_modify delay 0 exclude molecule/intra all\n"
                     : "read_data start.data\nneigh_modify delay 0\n";
  text += fmt::format("comm_modify vel yes cutoff {}\nneighbor {} bin\n",
                      digits((are_clumps ? 4.0 : 2.0) * bounding + skin),
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
                        vector_text(wall.points.front()),
                        vector_text(wall.normal.normalized()),
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
  // 3. Motion; weight acts on bodies, and not on their spheres
  const double gravity = spec.scene.gravity.norm();
  const Vec3 down = gravity > 0.0 ? Vec3(spec.scene.gravity / gravity) : Vec3(0.0, 0.0, -1.0);
  text += fmt::format("fix weight all gravity {} vector {}{}\n",
                      digits(gravity),
                      vector_text(down),
                      are_clumps ? " disable" : "");
  text += are_clumps
              ? "fix motion all rigid/small molecule infile bodies.txt gravity weight reinit "
                "no\ncompute body all rigid/local motion mol x y z\n"
              : "fix motion all nve/sphere\n";
  // 4. Frames
  text += are_clumps ? fmt::format(
                           "dump frames all local {} frames.txt c_body[1] c_body[2] c_body[3] "
                           "c_body[4]\ndump_modify frames format line \"%.0f %.17g %.17g %.17g\"\n",
                           scene.steps_a_frame)
                     : fmt::format(
                           "dump frames all custom {} frames.txt id x y z\ndump_modify frames "
                           "format line \"%d %.17g %.17g %.17g\"\n",
                           scene.steps_a_frame);
  text += fmt::format(
      "timestep {}\nthermo {}\nthermo_style custom step atoms\nthermo_modify lost error\n",
      digits(scene.time_step),
      std::max(1L, scene.steps / 10));
  // One only: at every further `run` LAMMPS converts the restitution of a wall once more
  text += fmt::format("run {}\n", scene.steps);
  Deck deck{.files = {{"deck.in", text}, {"start.data", start_data(started, are_clumps)}},
            .deck = "deck.in"};
  if (are_clumps) deck.files["bodies.txt"] = body_file(started);
  return deck;
}

class Lammps final : public Engine {
 public:
  std::string_view name() const override { return "lammps"; }
  std::string version() const override {
    static const std::string version = version_of_program("lmp", "lammps");
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
      for (const Clump& clump : scene.built.scene.types) {
        if (clump.spheres.size() > 1) {
          throw datasets::InputError(
              "the engine 'lammps' takes grains of one sphere only; use the engine 'embedded'.");
        }
      }
      return run_deck(spec, options, scene, deck_of(spec, scene), "lmp");
    } catch (const std::invalid_argument& error) {
      return {.status = RunStatus::unstable, .message = error.what()};
    }
  }
};

}  // namespace

const Engine& lammps_engine() {
  static const Lammps engine;
  return engine;
}

}  // namespace graintruth::calibrate
