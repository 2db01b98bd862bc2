// Section 3.7 simulated again: a row of spheres slides over three others of its kind, without
// friction; what holds it back is the lobes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/thesis/button.h"
#include "app/thesis/lone_row.h"
#include "app/thesis/targets.h"
#include "datasets/statistics/linear_least_squares.h"
#include "sim/laws/restitution.h"

namespace graintruth::app {

namespace {

using sim::Vec2;
using sim::Vec3;

const std::string misc = "ch3_misc";
const std::string study = "pseudo_friction";

// Three rows end to end on the floor between two walls, and one on top of the first.
struct Stack {
  double radius = 0.0;          // m
  double length = 0.0;          // m; of a row
  int spheres = 0;              // of a row
  double sphere_density = 0.0;  // q, diameter over spacing
  double spacing() const { return 2.0 * radius / sphere_density; }
};

Stack stack_of(const ThesisData& thesis, double sphere_density) {
  const double radius = thesis.setting(study, "element_radius");
  const double ratio = thesis.number(misc, "pseudo_friction_aspect_ratio");
  return {.radius = radius,
          .length = 2.0 * radius * ratio,
          .spheres = static_cast<int>(std::lround((ratio - 1.0) * sphere_density)) + 1,
          .sphere_density = sphere_density};
}

// Height of the upper row's axis at which it just touches the lower rows, m.
double touching_height(const Stack& stack, double first_sphere_x) {
  const double diameter = 2.0 * stack.radius;
  double height = 0.0;
  for (int upper = 0; upper < stack.spheres; ++upper) {
    const double x = first_sphere_x + upper * stack.spacing();
    for (int row = 0; row < 3; ++row) {
      for (int lower = 0; lower < stack.spheres; ++lower) {
        const double apart = x - (row * stack.length + stack.radius + lower * stack.spacing());
        if (std::abs(apart) < diameter)
          height = std::max(height, std::sqrt(diameter * diameter - apart * apart));
      }
    }
  }
  return stack.radius + height;
}

sim::Scene stacked(const ThesisData& thesis,
                   const Stack& stack,
                   double incline,
                   double start,
                   sim::Tension tension) {
  sim::Scene scene;
  scene.planar = true;
  scene.gravity = standard_gravity * Vec3(std::sin(incline), 0.0, -std::cos(incline));
  const int grain = scene.add_material(button_material(thesis));
  const int rigid = scene.add_material(sim::rigid_material());
  const double restitution = sim::restitution_of(thesis.setting(study, "damping_ratio"), tension);
  scene.surfaces.set(grain, grain, {.friction = 0.0, .restitution = restitution});
  scene.surfaces.set(grain, rigid, {.friction = 0.0, .restitution = restitution});
  const double mass = thesis.number(misc, "pseudo_friction_weight_q1") / standard_gravity;
  const int type = scene.add_type(sim::make_clump(
      sim::chain_of_spheres(stack.spheres, stack.radius, stack.spacing()), {.mass = mass}, grain));
  for (int row = 0; row < 3; ++row)
    scene.add_planar_body(type, Vec2((row + 0.5) * stack.length, stack.radius), 0.0);
  scene.add_planar_body(
      type,
      Vec2(0.5 * stack.length + start, touching_height(stack, stack.radius + start) + 1e-7),
      0.0);
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitX(), {}, rigid));
  scene.add_wall(sim::plane_wall(Vec3(3.0 * stack.length, 0.0, 0.0), -Vec3::UnitX(), {}, rigid));
  return scene;
}

// mu of eq 3.13 from the slope S of t^2 against X - X0:  S = 2 / (g (sin - mu cos)).
double friction_from(const std::vector<double>& times,
                     const std::vector<double>& ways,
                     double incline) {
  std::vector<double> squares;
  for (const double time : times) squares.push_back(time * time);
  const double slope = datasets::straight_line(ways, squares).slope;
  return std::tan(incline) - 2.0 / (slope * standard_gravity * std::cos(incline));
}

double pseudo_friction(const ThesisData& thesis,
                       const Stack& stack,
                       double phase,
                       const sim::SimulationOptions& law) {
  const double incline = thesis.si(misc, "pseudo_friction_incline");
  const double start = phase * stack.spacing();
  sim::SimulationOptions options = law;
  options.time_step = exactly(thesis.number(misc, "critical_time_step"));
  sim::Simulation simulation(stacked(thesis, stack, incline, start, law.tension), options);
  constexpr int upper = 3;
  const double from = simulation.state().position[upper].x();
  // As long as the upper row lies on the lower ones
  const double longest = 3.0 * stack.length - 0.5 * stack.length - from - 2.0 * stack.radius;
  std::vector<double> times, ways;
  bool at_end = false;
  const auto look = [&](const sim::State& state) {
    const double way = state.position[upper].x() - from;
    at_end = at_end || way > longest;
    if (at_end || state.time == 0.0) return;
    times.push_back(state.time);
    ways.push_back(way);
  };
  simulation.run_until(thesis.setting(study, "time"), {.interval = 1e-3, .observer = look});
  return friction_from(times, ways, incline);
}

struct Law {
  const char* name;
  sim::SimulationOptions options;
};

// Ours, and the thesis's own damping: no normalisation, contacts may pull, eq 1.21.
std::vector<Law> laws() {
  sim::SimulationOptions thesis_law;
  thesis_law.damping_sharing = sim::DampingSharing::none;
  thesis_law.tension = sim::Tension::allowed;
  thesis_law.damping_form = sim::DampingForm::thesis;
  return {{"ours", {}}, {"thesis", thesis_law}};
}

}  // namespace

void simulate_pseudo_friction(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "table_3_4_pseudo_friction";
  const datasets::Table& table = thesis.table(name);
  const std::vector<double> densities = table.numbers("sphere_density_q");
  const int seeds = thesis.count(study, "seeds");
  const std::vector<double> phases = shares_of_seed(studies.seed(), study, seeds);
  const std::string inputs =
      thesis.settings_text(study) + fmt::format("densities={} step={} weight={}",
                                                densities.size(),
                                                thesis.number(misc, "critical_time_step"),
                                                thesis.number(misc, "pseudo_friction_weight_q1"));
  const std::vector<Law> all = laws();
  const auto results = studies.result(exam.target(), inputs, [&] {
    const std::size_t rows = densities.size();
    std::vector<std::vector<std::vector<double>>> found(
        all.size(), std::vector<std::vector<double>>(rows, std::vector<double>(phases.size())));
    const int count = static_cast<int>(all.size() * rows) * seeds;
    studies.in_parallel(count, [&](int i) {
      const auto run = static_cast<std::size_t>(i);
      const std::size_t seed = run % phases.size();
      const std::size_t row = run / phases.size() % rows, law = run / phases.size() / rows;
      found[law][row][seed] =
          pseudo_friction(thesis, stack_of(thesis, densities[row]), phases[seed], all[law].options);
    });
    return Studies::Json(found);
  });

  const double tolerance = thesis.setting(study, "tolerance");
  Series printed{.name = "thesis, one run each"};
  Series ours{.name = "simulated again", .is_ours = true};
  Series bound{.name = "tan of the deviation of the contact normal", .is_line = true};
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Simulated found = over_seeds(results[0][row].get<std::vector<double>>());
    const Simulated in_thesis_manner = over_seeds(results[1][row].get<std::vector<double>>());
    const Printed cell = thesis.cell(name, row, "pseudo_friction_mu", "-");
    const auto agrees = [&](const Simulated& simulated) {
      return std::abs(simulated.mean - cell.value()) <= tolerance;
    };
    exam.contradictable(fmt::format("q = {}: pseudo-friction", densities[row]),
                        cell,
                        found,
                        tolerance,
                        agrees(found),
                        agrees(in_thesis_manner),
                        fmt::format("damped as in the thesis {:.3f} ± {:.3f}",
                                    in_thesis_manner.mean,
                                    in_thesis_manner.spread));
    printed.x.push_back(densities[row]);
    printed.y.push_back(cell.value());
    ours.x.push_back(densities[row]);
    ours.y.push_back(found.mean);
    ours.spread.push_back(found.spread);
    bound.x.push_back(densities[row]);
    bound.y.push_back(table.number(row, "tan_of_exact_angle"));
  }
  exam.add_curve({.id = "pseudo-friction",
                  .caption = "Friction of frictionless rows of spheres sliding over each other, "
                             "against the spheres a diameter. Ours: mean and standard deviation "
                             "over places of the start within a lobe.",
                  .x_title = "Sphere density q",
                  .y_title = "Pseudo-friction",
                  .series = {bound, printed, ours}});
}

}  // namespace graintruth::app
