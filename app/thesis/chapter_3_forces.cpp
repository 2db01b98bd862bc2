// Chapter 3 simulated again, at rest, in collision and in free flight: a lone row of spheres
// weighed, thrown at a wall, and pushed off its centre.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/thesis/button.h"
#include "app/thesis/chapter_3.h"
#include "app/thesis/lone_row.h"
#include "app/thesis/targets.h"
#include "sim/laws/restitution.h"

namespace graintruth::app {

using namespace chapter_3;

namespace {

using Json = Studies::Json;
using sim::Vec3;

// --- Tables 3.1 to 3.3 ---

struct AtRest {
  double force_error = 0.0;  // relative to the weight
  double early_error = 0.0;  // the same when the thesis looks
  double overlap = 0.0;      // m; of each contact
};

AtRest weigh(const ThesisData& thesis,
             bool upright,
             double damping_ratio,
             double step,
             sim::NormalSpring spring) {
  const double weight = thesis.number(misc, "weight_two_sphere_particle");
  LoneRow row{.spheres = 2,
              .radius = thesis.setting("weight", "element_radius"),
              .spacing = thesis.setting("weight", "centre_spacing"),
              .mass = weight / standard_gravity,
              .material = button_material(thesis),
              .restitution = sim::restitution_of(damping_ratio, sim::Tension::clipped),
              .is_upright = upright};
  sim::Simulation simulation = on_plane(row, step, {.normal_spring = spring});
  const auto error = [&] {
    return std::abs(std::abs(simulation.wall_force(0).z()) - weight) / weight;
  };
  AtRest result;
  simulation.run_until(thesis.number(misc, "weight_fig_time"));
  result.early_error = error();
  simulation.run_until(thesis.setting("weight", "time"));
  result.force_error = error();
  for (const sim::ContactReport& contact : simulation.contacts())
    result.overlap = std::max(result.overlap, contact.overlap);
  return result;
}

// W/n = (4/3) E* sqrt(R) d^1.5, E* = E/(1 - nu^2) on a rigid wall
double hertz_overlap(const ThesisData& thesis, double contacts) {
  const sim::Material material = button_material(thesis);
  const double modulus =
      material.youngs_modulus / (1.0 - material.poisson_ratio * material.poisson_ratio);
  const double load = thesis.number(misc, "weight_two_sphere_particle") / contacts;
  return std::pow(
      load / (4.0 / 3.0 * modulus * std::sqrt(thesis.setting("weight", "element_radius"))),
      2.0 / 3.0);
}

void simulate_weight(Examination& exam,
                     const ThesisData& thesis,
                     Studies& studies,
                     const std::string& name) {
  const datasets::Table& table = thesis.table(name);
  const bool upright = table.text(0, "orientation") == "vertical";
  const double contacts = table.number(0, "contacts");
  const double damping_ratio = table.number(0, "damping_ratio_beta");
  const std::vector<double> steps = table.numbers("time_step_s");
  const std::string inputs = inputs_of(thesis, "weight") +
                             fmt::format("upright={} beta={} steps={} springs=hertz,incremental",
                                         upright,
                                         damping_ratio,
                                         table.text(0, "time_step_s"));
  const Json results = studies.result(exam.target(), inputs, [&] {
    const auto count = static_cast<int>(steps.size());
    std::vector<AtRest> total(steps.size()), incremental(steps.size());
    studies.in_parallel(2 * count, [&](int i) {
      const auto step = static_cast<std::size_t>(i % count);
      const bool is_total = i < count;
      (is_total ? total : incremental)[step] =
          weigh(thesis,
                upright,
                damping_ratio,
                steps[step],
                is_total ? sim::NormalSpring::hertz : sim::NormalSpring::incremental);
    });
    Json json = Json::array();
    for (std::size_t i = 0; i < total.size(); ++i) {
      json.push_back({{"force_error", total[i].force_error},
                      {"early_error", total[i].early_error},
                      {"overlap", total[i].overlap},
                      {"incremental_force_error", incremental[i].force_error},
                      {"incremental_overlap", incremental[i].overlap}});
    }
    return json;
  });

  const double tolerance = thesis.setting("weight", "force_tolerance");
  const double hertz = hertz_overlap(thesis, contacts);
  const double overlap_tolerance = thesis.setting("weight", "overlap_tolerance");
  std::vector<double> errors, drifts;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string step = fmt::format("step {} s: ", table.text(row, "time_step_s"));
    const double error = number_at(results[row], "force_error");
    errors.push_back(100.0 * error);
    exam.claim(step + "the wall carries the weight, error",
               thesis.cell(name, row, "error_printed_percent", "percent"),
               {.mean = 100.0 * error},
               100.0 * tolerance,
               error <= tolerance,
               fmt::format("our error after 0.005 s of falling into contact: {:.2g} %",
                           100.0 * number_at(results[row], "early_error")));
    const double overlap = number_at(results[row], "overlap");
    Row& deformation = exam.claim_value(step + "deformation at rest",
                                        thesis.cell(name, row, "deformation_m", "m"),
                                        {.mean = overlap},
                                        overlap_tolerance * hertz,
                                        "");
    deformation.recomputed = hertz;
    if (std::abs(overlap / hertz - 1.0) > overlap_tolerance) deformation.verdict = Verdict::fail;
    drifts.push_back(std::abs(number_at(results[row], "incremental_overlap") / hertz - 1.0));
    exam.add_note(fmt::format(
        "{}with the incremental force of the thesis the particle rests {:.3g} % off Hertz's "
        "overlap, and the wall carries its weight to {:.2g} %.",
        step,
        100.0 * drifts.back(),
        100.0 * number_at(results[row], "incremental_force_error")));
  }
  exam.claim("the error grows as the step falls",
             {"grows", "percent", "sec 3.2"},
             {.mean = largest_of(errors)},
             100.0 * tolerance,
             largest_of(errors) > 100.0 * tolerance,
             "largest error of the three steps");
  exam.claim("the incremental force drifts: at rest its overlap is not Hertz's",
             {"drifts", "percent", "eqs 1.54, 1.55"},
             {.mean = 100.0 * largest_of(drifts)},
             100.0 * overlap_tolerance,
             largest_of(drifts) > overlap_tolerance,
             "largest deviation of the three steps; the spring on the total overlap, our default, "
             "stays within the tolerance");
  exam.add_note(
      "Overlaps are recomputed from Hertz's law for a load at rest. Our contact force follows from "
      "the total overlap and cannot drift; the incremental force of the thesis (1.54, 1.55) is an "
      "option of the simulator that only shows its drift.");
}

// --- Figure 3.5 ---

// Relative error of half the impulse of an elastic rebound against m v (3.5).
double impulse_error(const ThesisData& thesis, double step, double phase) {
  const double speed = thesis.setting("collision", "speed");
  LoneRow row{.spheres = 2,
              .radius = thesis.setting("weight", "element_radius"),
              .spacing = thesis.setting("weight", "centre_spacing"),
              .mass = thesis.number(misc, "weight_two_sphere_particle") / standard_gravity,
              .material = button_material(thesis),
              .restitution = 1.0,
              .is_upright = true,
              .gravity = Vec3::Zero(),
              .gap = (1.0 + phase) * speed * step,
              .velocity = Vec3(0.0, 0.0, -speed)};
  sim::Simulation simulation = on_plane(row, step);
  const double start = simulation.state().velocity[0].z();
  double duration = 2.0 * row.gap / speed;
  do {
    duration += 100.0 * critical_step(thesis);
    simulation.run_until(duration);
  } while (!simulation.contacts().empty());
  const double impulse = row.mass * (simulation.state().velocity[0].z() - start);
  return std::abs(0.5 * impulse / (row.mass * speed) - 1.0);
}

}  // namespace

void simulate_table_3_1(Examination& exam, const ThesisData& thesis, Studies& studies) {
  simulate_weight(exam, thesis, studies, "table_3_1_weight_vertical_beta050");
}
void simulate_table_3_2(Examination& exam, const ThesisData& thesis, Studies& studies) {
  simulate_weight(exam, thesis, studies, "table_3_2_weight_vertical_beta021");
}
void simulate_table_3_3(Examination& exam, const ThesisData& thesis, Studies& studies) {
  simulate_weight(exam, thesis, studies, "table_3_3_weight_horizontal_beta050");
}

void simulate_collision(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "ch3_impulse_error";
  const datasets::Table& table = thesis.table(name);
  const std::vector<double> fractions = table.numbers("frac");
  const int seeds = thesis.count("collision", "seeds");
  const std::vector<double> phases = shares_of_seed(studies.seed(), "collision", seeds);
  const std::string inputs = inputs_of(thesis, "collision") + inputs_of(thesis, "weight") +
                             fmt::format("fractions={}", fractions.size());
  const Json results = studies.result(exam.target(), inputs, [&] {
    std::vector<std::vector<double>> errors(fractions.size(), std::vector<double>(phases.size()));
    studies.in_parallel(static_cast<int>(fractions.size()) * seeds, [&](int i) {
      const auto row = static_cast<std::size_t>(i / seeds),
                 seed = static_cast<std::size_t>(i % seeds);
      errors[row][seed] =
          100.0 * impulse_error(thesis, fractions[row] * critical_step(thesis), phases[seed]);
    });
    return Json(errors);
  });

  Series printed{.name = "thesis"}, ours{.name = "simulated again", .is_ours = true};
  std::vector<Simulated> errors;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    errors.push_back(over_seeds(results[row].get<std::vector<double>>()));
    ours.x.push_back(fractions[row]);
    ours.y.push_back(errors[row].mean);
    ours.spread.push_back(errors[row].spread);
  }
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string where = fmt::format("frac {}: error of the impulse", table.text(row, "frac"));
    const Printed cell = thesis.cell(name, row, "impulse_error_percent", "percent");
    if (std::isfinite(cell.value())) {
      exam.claim(where,
                 cell,
                 errors[row],
                 cell.value(),
                 errors[row].mean <= cell.value(),
                 "ours must not be larger");
      printed.x.push_back(fractions[row]);
      printed.y.push_back(cell.value());
    } else {
      // Against the row before: no better, or much worse
      const bool no_better = errors[row].mean >= 0.5 * errors[row - 1].mean;
      const bool much_worse = errors[row].mean >= 2.0 * errors[row - 1].mean;
      exam.claim(where,
                 cell,
                 errors[row],
                 no_number,
                 cell.text.starts_with("sharp") ? much_worse : no_better,
                 "in double precision the error goes on falling");
    }
  }
  exam.add_curve({.id = "impulse-error",
                  .caption = "Error of the impulse of an elastic rebound against the time step, as "
                             "a fraction of the thesis's critical step. Ours: mean and standard "
                             "deviation over places of the start within a step.",
                  .x_title = "frac",
                  .y_title = "Error (%)",
                  .log_x = true,
                  .log_y = true,
                  .series = {printed, ours}});
}

// --- Section 3.6 ---

void simulate_impulse(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "ch3_rotation_translation";
  const double mass = thesis.number(name, "mass"), step = thesis.number(name, "time_step");
  const double velocity = thesis.number(name, "force") / mass * step;
  const double turning = thesis.number(name, "angular_acceleration") * step;
  const double time = thesis.setting("impulse", "time");
  const std::vector<double> ratios = thesis.settings("impulse", "damping_ratio");
  LoneRow row{.spheres = static_cast<int>(thesis.number(name, "element_spheres")),
              .radius = thesis.si(name, "element_radius_implied"),
              .spacing = thesis.si(name, "centre_spacing_implied"),
              .mass = mass,
              .material = button_material(thesis),
              .gravity = Vec3::Zero(),
              .gap = 2.0 * velocity * time,
              .velocity = Vec3(0.0, 0.0, -velocity),
              .picture_spin = turning};
  const std::string inputs =
      inputs_of(thesis, "impulse") + inputs_of(thesis, "weight") +
      fmt::format("v={} w={} m={} R={} s={}", velocity, turning, mass, row.radius, row.spacing);
  const Json results = studies.result(exam.target(), inputs, [&] {
    // Free motion: what the places and angles of two moments say
    sim::Simulation free = on_plane(row, step);
    const sim::State start = free.state();
    free.run_until(time);
    const sim::State end = free.state();
    // Against the plane, flat, at three dampings
    std::vector<double> rebounds(ratios.size());
    studies.in_parallel(static_cast<int>(ratios.size()), [&](int i) {
      const auto which = static_cast<std::size_t>(i);
      LoneRow falling = row;
      falling.gap = 1e-5;
      falling.restitution =
          ratios[which] > 0.0 ? sim::restitution_of(ratios[which], sim::Tension::clipped) : 1.0;
      sim::Simulation simulation = on_plane(falling, 0.1 * step);
      simulation.run_until(time);
      rebounds[which] = simulation.state().velocity[0].z();
    });
    return Json{{"velocity", (start.position[0].z() - end.position[0].z()) / time},
                {"turning", (end.picture_angle[0] - start.picture_angle[0]) / time},
                {"rebounds", rebounds}};
  });

  const double tolerance = thesis.setting("impulse", "tolerance");
  const auto exact =
      [&](const std::string& where, const char* printed, const char* key, double theory) {
        const double found = number_at(results, key);
        Row& kept = exam.claim(where,
                               thesis.printed(name, printed),
                               {.mean = found},
                               tolerance * theory,
                               std::abs(found - theory) <= tolerance * theory,
                               "from the way of a free flight");
        kept.recomputed = theory;
      };
  exact("velocity is kept", "velocity_theory", "velocity", velocity);
  exact("angular velocity is kept", "angular_velocity_theory", "turning", turning);
  const Printed simulated = thesis.printed(name, "velocity_simulated");
  exam.claim_value("simulated velocity",
                   simulated,
                   {.mean = number_at(results, "velocity")},
                   simulated.rounding());
  const Printed turned = thesis.printed(name, "angular_velocity_simulated");
  exam.claim_value("simulated angular velocity",
                   turned,
                   {.mean = number_at(results, "turning")},
                   turned.rounding());
  const std::vector<double> rebounds = numbers_at(results, "rebounds");
  exam.claim("more damping, slower rebound",
             {"slower", "m/s", "sec 3.6, fig 3.14"},
             {.mean = rebounds.back()},
             no_number,
             std::is_sorted(rebounds.rbegin(), rebounds.rend()) && rebounds.back() < rebounds[0],
             fmt::format("speed of the centroid after the collision at the largest damping; "
                         "{:.4f} m/s without",
                         rebounds[0]));
}

}  // namespace graintruth::app
