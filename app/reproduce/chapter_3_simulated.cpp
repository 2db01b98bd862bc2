// Chapter 3 simulated again: a lone row of spheres at rest, in collision, sliding, conveyed, spun,
// and sliding over others of its kind.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/reproduce/button.h"
#include "app/reproduce/lone_row.h"
#include "app/reproduce/targets.h"
#include "sim/restitution.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;
using sim::Vec3;

const std::string misc = "ch3_misc";

double critical_step(const ThesisData& thesis) { return thesis.number(misc, "critical_time_step"); }

// All that chapter 3's studies share, and the study's own settings.
std::string inputs_of(const ThesisData& thesis, const std::string& study) {
  const sim::Material material = button_material(thesis);
  return fmt::format("{} E={} nu={} step={} weight={}",
                     thesis.settings_text(study),
                     material.youngs_modulus,
                     material.poisson_ratio,
                     critical_step(thesis),
                     thesis.number(misc, "weight_two_sphere_particle"));
}

double number_at(const Json& json, const char* key) { return json.at(key).get<double>(); }
std::vector<double> numbers_at(const Json& json, const char* key) {
  return json.at(key).get<std::vector<double>>();
}

double largest_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

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

// --- Figures 3.7, 3.8 ---

namespace {

struct Slide {
  double friction = 0.0;
  int spheres = 0;
  double spacing = 0.0;  // m
  double tangential_damping = 0.0;
  sim::CoulombLimit limit = sim::CoulombLimit::whole;
  sim::DampingSharing sharing = sim::DampingSharing::inv_sqrt_n;
};

double incline_of(const ThesisData& thesis) { return thesis.si("ch3_sliding", "incline"); }

// Acceleration along the incline between two moments after a small fall, m/s2.
double slide(const ThesisData& thesis, const Slide& slide, double height_share) {
  const double incline = incline_of(thesis);
  const double ratio = thesis.setting("sliding", "damping_ratio");
  LoneRow row{.spheres = slide.spheres,
              .radius = thesis.setting("sliding", "element_radius"),
              .spacing = slide.spacing,
              .mass = thesis.number(misc, "weight_two_sphere_particle") / standard_gravity,
              .material = button_material(thesis),
              .friction = slide.friction,
              .restitution = sim::restitution_of(ratio, sim::Tension::clipped),
              .gravity = standard_gravity * Vec3(std::sin(incline), 0.0, -std::cos(incline)),
              .gap = height_share * thesis.setting("sliding", "drop_height")};
  sim::SimulationOptions options;
  options.tangential_damping = slide.tangential_damping;
  options.coulomb_limit = slide.limit;
  options.damping_sharing = slide.sharing;
  sim::Simulation simulation = on_plane(row, critical_step(thesis), options);
  const double from = thesis.setting("sliding", "from"), to = thesis.setting("sliding", "to");
  simulation.run_until(from);
  const double early = simulation.state().velocity[0].x();
  simulation.run_until(to);
  return (simulation.state().velocity[0].x() - early) / (to - from);
}

double coulomb_acceleration(const ThesisData& thesis, double friction) {
  const double incline = incline_of(thesis);
  return standard_gravity * (std::sin(incline) - friction * std::cos(incline));
}

// One value a slide and seed.
Json slide_all(const ThesisData& thesis, Studies& studies, const std::vector<Slide>& slides) {
  const int seeds = thesis.count("sliding", "seeds");
  const std::vector<double> heights = shares_of_seed(studies.seed(), "sliding", seeds);
  std::vector<std::vector<double>> found(slides.size(), std::vector<double>(heights.size()));
  studies.in_parallel(static_cast<int>(slides.size()) * seeds, [&](int i) {
    const auto which = static_cast<std::size_t>(i / seeds),
               seed = static_cast<std::size_t>(i % seeds);
    found[which][seed] = slide(thesis, slides[which], heights[seed]);
  });
  return found;
}

}  // namespace

void simulate_sliding(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::vector<double> frictions = thesis.settings("sliding", "friction");
  const double spacing = thesis.setting("sliding", "centre_spacing");
  const int spheres = static_cast<int>(thesis.number("ch3_sliding", "element_spheres_fig_3_7"));
  const double damped_friction = thesis.number("ch3_sliding", "friction_fig_3_8");
  std::vector<Slide> slides;
  for (const double friction : frictions)
    slides.push_back({.friction = friction, .spheres = spheres, .spacing = spacing});
  Slide damped{.friction = damped_friction,
               .spheres = spheres,
               .spacing = spacing,
               .tangential_damping = 1.0};
  slides.push_back(damped);
  damped.limit = sim::CoulombLimit::spring;
  slides.push_back(damped);
  const Json results = studies.result(exam.target(), inputs_of(thesis, "sliding") + "damped", [&] {
    return slide_all(thesis, studies, slides);
  });

  const double tolerance = thesis.setting("sliding", "tolerance");
  Series theory{.name = "theory (3.6)", .is_line = true};
  Series ours{.name = "simulated again", .is_ours = true};
  for (std::size_t i = 0; i < frictions.size(); ++i) {
    const Simulated found = over_seeds(results[i].get<std::vector<double>>());
    const double exact = coulomb_acceleration(thesis, frictions[i]);
    Row& row = exam.claim(fmt::format("friction {}: sliding as by eq 3.6", frictions[i]),
                          {"agrees with theory", "m/s2", "Fig 3.7"},
                          found,
                          tolerance * exact,
                          std::abs(found.mean - exact) <= tolerance * exact,
                          "acceleration, without tangential damping");
    row.recomputed = exact;
    theory.x.push_back(frictions[i]);
    theory.y.push_back(exact);
    ours.x.push_back(frictions[i]);
    ours.y.push_back(found.mean);
    ours.spread.push_back(found.spread);
  }

  // Figure 3.8: with tangential damping the particle is held back, or sticks
  const double exact = coulomb_acceleration(thesis, damped_friction);
  const Simulated whole = over_seeds(results[frictions.size()].get<std::vector<double>>());
  const Simulated late = over_seeds(results[frictions.size() + 1].get<std::vector<double>>());
  const bool held_back = whole.mean < (1.0 - tolerance) * exact;
  const bool late_held_back = late.mean < (1.0 - tolerance) * exact;
  Row& row = exam.contradictable(
      fmt::format("friction {}: tangential damping holds back the sliding", damped_friction),
      {"held back", "m/s2", "Fig 3.8"},
      whole,
      tolerance * exact,
      held_back,
      late_held_back,
      fmt::format("Coulomb's limit on spring and dashpot together leaves the theory's "
                  "acceleration; in the thesis's manner, with the dashpot added to a spring that "
                  "alone is limited, it is {:.3f} m/s2",
                  late.mean));
  row.recomputed = exact;
  exam.add_curve({.id = "sliding",
                  .caption = "Acceleration down 30 degrees against friction, without tangential "
                             "damping.",
                  .x_title = "Friction",
                  .y_title = "Acceleration (m/s2)",
                  .series = {theory, ours}});
}

// --- Figure 3.11 and conclusion 6.1-iii ---

namespace {

struct Sharing {
  sim::DampingSharing how;
  const char* column;
  const char* words;
};
constexpr std::array sharings = {
    Sharing{sim::DampingSharing::none, "e_no_normalisation", "damping contact by contact"},
    Sharing{sim::DampingSharing::inv_n, "e_c1_over_N", "damping over N"},
    Sharing{sim::DampingSharing::inv_sqrt_n, "e_c1_over_sqrtN", "damping over sqrt N"}};

// Rebound speed over impact speed of a row that falls flat on a plane, without weight.
double flat_rebound(const ThesisData& thesis,
                    int contacts,
                    double asked,
                    sim::DampingSharing sharing) {
  const double speed = thesis.setting("contact_count", "impact_speed");
  const double radius = thesis.setting("sliding", "element_radius");
  const double step = 0.1 * critical_step(thesis);
  LoneRow row{.spheres = contacts,
              .radius = radius,
              .spacing = 2.0 * radius,
              .mass = thesis.number(misc, "weight_two_sphere_particle") / standard_gravity,
              .material = button_material(thesis),
              .restitution = asked,
              .gravity = Vec3::Zero(),
              .gap = 2.0 * speed * step,
              .velocity = Vec3(0.0, 0.0, -speed)};
  sim::SimulationOptions options;
  options.damping_sharing = sharing;
  options.tension = sim::Tension::allowed;
  sim::Simulation simulation = on_plane(row, step, options);
  double time = 0.0;
  do {
    time += 1000.0 * step;
    simulation.run_until(time);
  } while (!simulation.contacts().empty());
  return simulation.state().velocity[0].z() / speed;
}

Json rebound_all(const ThesisData& thesis, Studies& studies) {
  const datasets::Table& table = thesis.table("derived_multicontact_restitution");
  const double asked = table.number(0, "e_c1_over_sqrtN");
  const int count = static_cast<int>(table.rows());
  std::vector<std::vector<double>> found(table.rows(), std::vector<double>(sharings.size()));
  studies.in_parallel(count, [&](int i) {
    const auto row = static_cast<std::size_t>(i);
    for (std::size_t how = 0; how < sharings.size(); ++how) {
      found[row][how] =
          flat_rebound(thesis, table.integer(row, "contacts_N"), asked, sharings[how].how);
    }
  });
  return found;
}

}  // namespace

void simulate_contact_count(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "derived_multicontact_restitution";
  const datasets::Table& table = thesis.table(name);
  const double tolerance = thesis.setting("contact_count", "tolerance");
  const std::string inputs = inputs_of(thesis, "contact_count") + inputs_of(thesis, "sliding");

  // 1. Rebound of N simultaneous contacts
  const Json rebounds =
      studies.result("fig-3.11-rebound", inputs, [&] { return rebound_all(thesis, studies); });
  std::vector<Series> curves;
  for (std::size_t how = 0; how < sharings.size(); ++how) {
    Series curve{.name = sharings[how].words, .is_ours = true};
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const double found = rebounds[row][how].get<double>();
      const Printed wanted = thesis.cell(name, row, sharings[how].column, "-");
      exam.claim_value(
          fmt::format(
              "{} contacts: restitution, {}", table.text(row, "contacts_N"), sharings[how].words),
          wanted,
          {.mean = found},
          tolerance * wanted.value(),
          "derived by integrating the flat impact");
      curve.x.push_back(table.number(row, "contacts_N"));
      curve.y.push_back(found);
    }
    curves.push_back(curve);
  }
  exam.add_curve({.id = "contact-count",
                  .caption = "Restitution of a flat impact against the number of simultaneous "
                             "contacts. Only damping shared by the square root of their number "
                             "gives what is asked for any number.",
                  .x_title = "Contacts",
                  .y_title = "Restitution",
                  .series = curves});

  // 2. Sliding with more or fewer spheres of the same length and weight
  const std::vector<double> counts = thesis.settings("contact_count", "spheres");
  const std::vector<double> frictions = thesis.settings("contact_count", "friction");
  const double length = thesis.setting("contact_count", "length");
  std::vector<Slide> slides;
  for (const double friction : frictions) {
    for (const double count : counts) {
      slides.push_back({.friction = friction,
                        .spheres = static_cast<int>(count),
                        .spacing = length / (count - 1.0),
                        .sharing = sim::DampingSharing::none});
    }
  }
  const Json slid = studies.result(
      "fig-3.11-sliding", inputs, [&] { return slide_all(thesis, studies, slides); });
  const double slide_tolerance = thesis.setting("sliding", "tolerance");
  for (std::size_t i = 0; i < frictions.size(); ++i) {
    const Simulated few = over_seeds(slid[i * counts.size()].get<std::vector<double>>());
    const Simulated many = over_seeds(slid[(i + 1) * counts.size() - 1].get<std::vector<double>>());
    const double exact = coulomb_acceleration(thesis, frictions[i]);
    Row& row = exam.claim(
        fmt::format("friction {}: more contacts hold back the sliding", frictions[i]),
        {"held back", "m/s2", "Fig 3.11"},
        many,
        slide_tolerance * exact,
        many.mean < few.mean - slide_tolerance * exact,
        fmt::format(
            "acceleration with {} spheres, damping contact by contact; with {} it is {:.4f} "
            "m/s2",
            counts.back(),
            counts.front(),
            few.mean));
    row.recomputed = exact;
  }
}

// --- Figure 3.12 ---

namespace {

struct Belt {
  double friction = 0.0, damping_ratio = 0.0, step_fraction = 0.0;
};

struct Conveyed {
  double final_speed = 0.0, largest_speed = 0.0;  // m/s
  double transient = 0.0;                         // s; until it stays near the belt's speed
};

Conveyed convey(const ThesisData& thesis, const Belt& belt, double height_share) {
  const double speed = thesis.number(misc, "conveyor_speed");
  LoneRow row{.spheres = static_cast<int>(thesis.number(misc, "conveyor_particle_spheres")),
              .radius = thesis.setting("conveyor", "element_radius"),
              .spacing = thesis.setting("conveyor", "centre_spacing"),
              .mass = thesis.number(misc, "weight_two_sphere_particle") / standard_gravity,
              .material = button_material(thesis),
              .friction = belt.friction,
              .restitution = sim::restitution_of(belt.damping_ratio, sim::Tension::clipped),
              .gap = height_share * thesis.setting("conveyor", "drop_height"),
              .belt_speed = speed};
  sim::Simulation simulation = on_plane(row, belt.step_fraction * critical_step(thesis));
  const double settled = thesis.setting("conveyor", "settled") * speed;
  Conveyed result;
  const auto look = [&](const sim::State& state) {
    const double now = state.velocity[0].x();
    result.largest_speed = std::max(result.largest_speed, now);
    result.final_speed = now;
    if (std::abs(now - speed) > settled) result.transient = state.time;
  };
  simulation.run_until(thesis.setting("conveyor", "time"), {.interval = 1e-4, .observer = look});
  return result;
}

}  // namespace

void simulate_conveyor(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::vector<double> frictions = thesis.settings("conveyor", "friction");
  const std::vector<double> ratios = thesis.settings("conveyor", "damping_ratio");
  const std::vector<double> fractions = thesis.settings("conveyor", "step_fraction");
  // The first is the base; each other changes one thing
  const std::vector<Belt> belts = {{frictions[0], ratios[0], fractions[0]},
                                   {frictions[0], ratios[0], fractions[1]},
                                   {frictions[0], ratios[1], fractions[0]},
                                   {frictions[1], ratios[0], fractions[0]}};
  const int seeds = thesis.count("conveyor", "seeds");
  const std::vector<double> heights = shares_of_seed(studies.seed(), "conveyor", seeds);
  const Json results = studies.result(exam.target(), inputs_of(thesis, "conveyor"), [&] {
    std::vector<std::vector<Conveyed>> found(belts.size(), std::vector<Conveyed>(heights.size()));
    studies.in_parallel(static_cast<int>(belts.size()) * seeds, [&](int i) {
      const auto which = static_cast<std::size_t>(i / seeds);
      const auto seed = static_cast<std::size_t>(i % seeds);
      found[which][seed] = convey(thesis, belts[which], 0.5 + 0.5 * heights[seed]);
    });
    Json json = Json::array();
    for (const auto& runs : found) {
      std::vector<double> last, most, transient;
      for (const Conveyed& run : runs) {
        last.push_back(run.final_speed);
        most.push_back(run.largest_speed);
        transient.push_back(run.transient);
      }
      json.push_back({{"final", last}, {"largest", most}, {"transient", transient}});
    }
    return json;
  });

  const double tolerance = thesis.setting("conveyor", "tolerance");
  const Printed speed = thesis.printed(misc, "conveyor_speed");
  exam.claim_value("speed after the transient",
                   speed,
                   over_seeds(numbers_at(results[0], "final")),
                   tolerance * speed.value());
  const Simulated largest = over_seeds(numbers_at(results[0], "largest"));
  exam.claim("at first faster than the belt",
             {"faster", "m/s", "sec 3.5, fig 3.12"},
             largest,
             no_number,
             largest.mean > (1.0 + thesis.setting("conveyor", "settled")) * speed.value(),
             "largest speed");
  const Simulated base = over_seeds(numbers_at(results[0], "transient"));
  const auto compare = [&](const char* where, const char* words, std::size_t which, double sign) {
    const Simulated changed = over_seeds(numbers_at(results[which], "transient"));
    // Two standard errors of the difference of the means
    const double noise =
        2.0 * std::sqrt((base.spread * base.spread + changed.spread * changed.spread) / base.seeds);
    exam.claim(where,
               {words, "s", "fig 3.12"},
               changed,
               noise,
               sign * (changed.mean - base.mean) > noise,
               fmt::format("time until the speed stays within 2 % of the belt's; {:.4f} s before "
                           "the change",
                           base.mean));
  };
  compare("a smaller step shortens the transient", "shorter", 1, -1.0);
  compare("more damping shortens the transient", "shorter", 2, -1.0);
  compare("less friction lengthens the transient", "longer", 3, 1.0);
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
