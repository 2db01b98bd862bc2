// Chapter 3 simulated again, with friction: a lone row of spheres on an incline, with one and
// several contacts, and on a conveyor.
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

// --- Figures 3.7, 3.8 ---

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

}  // namespace graintruth::app
