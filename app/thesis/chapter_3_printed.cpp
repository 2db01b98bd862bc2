// Chapter 3 from printed data: weight at rest, pseudo-friction, run times, an impulse.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/thesis/targets.h"
#include "sim/shapes/surface_error.h"

namespace graintruth::app {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// Error (%) = |F - W| / W x 100   (3.1)
void examine_weight(Examination& exam, const ThesisData& thesis, const std::string& name) {
  const datasets::Table& table = thesis.table(name);
  const double weight = thesis.number("ch3_misc", "weight_two_sphere_particle");
  const double implied = thesis.number("ch3_misc", "weight_implied_by_error_columns");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string step = fmt::format("step {} s", table.text(row, "time_step_s"));
    const Printed error = thesis.cell(name, row, "error_printed_percent", "percent");
    const double difference = table.number(row, "force_minus_weight_N");
    exam.compare(
        fmt::format("{}: error, W = {} N", step, weight), error, 100.0 * difference / weight);
    exam.compare(fmt::format("{}: error, W = {} N", step, implied),
                 error,
                 100.0 * difference / implied,
                 "the weight that most of the column implies");
  }
}

}  // namespace

void examine_table_3_1(Examination& exam, const ThesisData& thesis) {
  examine_weight(exam, thesis, "table_3_1_weight_vertical_beta050");
}
void examine_table_3_2(Examination& exam, const ThesisData& thesis) {
  examine_weight(exam, thesis, "table_3_2_weight_vertical_beta021");
}
void examine_table_3_3(Examination& exam, const ThesisData& thesis) {
  examine_weight(exam, thesis, "table_3_3_weight_horizontal_beta050");
}

void examine_table_3_4(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_3_4_pseudo_friction";
  const datasets::Table& table = thesis.table(name);
  // Equal spheres of diameter 1 and spacing 1/q: the contact normal deviates by asin(1/2q)
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double density = table.number(row, "sphere_density_q");
    const std::string q = fmt::format("q = {}: ", density);
    exam.compare(q + "deviation of the contact normal",
                 thesis.cell(name, row, "contact_normal_deviation_printed_deg", "deg"),
                 sim::contact_normal_error(0.5, 0.5, 1.0 / density, 0.5) / degree);
    exam.compare(q + "overlap",
                 thesis.cell(name, row, "overlap_percent_of_diameter", "percent"),
                 100.0 * (1.0 - 1.0 / density));
  }

  // Eqs 3.14, 3.15: F_n = W cos(theta), mu = F_t / F_n
  const std::string misc = "ch3_misc";
  const double normal = thesis.number(misc, "pseudo_friction_weight_q1") *
                        std::cos(thesis.si(misc, "pseudo_friction_incline"));
  exam.compare(
      "eq 3.14: normal force", thesis.printed(misc, "pseudo_friction_normal_force_q1"), normal);
  exam.compare("eq 3.15: friction from forces",
               thesis.printed(misc, "pseudo_friction_mu_from_forces_q1"),
               thesis.number(misc, "pseudo_friction_tangential_force_q1") / normal);

  // Section 3.8 for equal spheres of diameter 1: dx = R_s sin(gamma_1), dy = R_s - o_s m with
  // o_s k = R_s + R_1 (1 - 1/cos(gamma_1)); dy = (R_s - o_s k) cos(gamma_1)   (3.20, 3.21)
  const auto shifts = [&](const std::string& which, double density) {
    const double gamma = sim::contact_normal_error(0.5, 0.5, 1.0 / density, 0.5);
    const double inside = 0.5 + 0.5 * (1.0 - 1.0 / std::cos(gamma));
    exam.compare(fmt::format("sec 3.8, q = {}: angle", density),
                 thesis.printed(misc, which + "_gamma"),
                 gamma / degree);
    exam.compare(fmt::format("sec 3.8, q = {}: dx", density),
                 thesis.printed(misc, which + "_dx"),
                 0.5 * std::sin(gamma));
    exam.compare(fmt::format("sec 3.8, q = {}: dy", density),
                 thesis.printed(misc, which + "_dy"),
                 (0.5 - inside) * std::cos(gamma));
  };
  shifts("max_contact_error_q1", table.number(0, "sphere_density_q"));
  shifts("contact_error_q4", table.number(table.rows() - 1, "sphere_density_q"));
}

void examine_table_3_5(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_3_5_run_time_multisphere";
  const datasets::Table& table = thesis.table(name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const int spheres = table.integer(row, "spheres_per_particle");
    exam.compare(fmt::format("{} spheres a particle: time of a sphere and step", spheres),
                 thesis.cell(name, row, "run_time_per_sphere_per_step_s", "s"),
                 table.number(row, "run_time_per_particle_per_step_printed_s") / spheres,
                 "from the time of a particle");
    exam.take(fmt::format("{} spheres a particle: time of a particle and step", spheres),
              thesis.cell(name, row, "run_time_per_particle_per_step_printed_s", "s"));
  }
}

void examine_table_3_6(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_3_6_run_time_spheres";
  const datasets::Table& table = thesis.table(name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    exam.take(
        fmt::format("{} spheres: time of a sphere and step", table.text(row, "total_spheres")),
        thesis.cell(name, row, "run_time_per_sphere_per_step_s", "s"));
  }
}

void examine_impulse(Examination& exam, const ThesisData& thesis) {
  const std::string name = "ch3_rotation_translation";
  const double step = thesis.number(name, "time_step");
  const double force = thesis.number(name, "force");
  const Printed inertia = thesis.printed(name, "moment_of_inertia");
  for (const char* quantity : {"mass", "moment_of_inertia", "time_step", "force", "lever_arm"})
    exam.take(quantity, thesis.printed(name, quantity));
  const double acceleration = force / thesis.number(name, "mass");
  exam.compare(
      "eq 3.7: linear acceleration", thesis.printed(name, "linear_acceleration"), acceleration);
  const double turning = force * thesis.number(name, "lever_arm") / inertia.value();
  exam.compare_within("eq 3.8: angular acceleration",
                      thesis.printed(name, "angular_acceleration"),
                      turning,
                      turning * inertia.rounding() / inertia.value(),
                      "within the rounding of the inertia; 2.433e-5 kg m2 gives the digits");
  exam.compare("eq 3.9: velocity", thesis.printed(name, "velocity_theory"), acceleration * step);
  exam.compare("eq 3.10: angular velocity",
               thesis.printed(name, "angular_velocity_theory"),
               thesis.number(name, "angular_acceleration") * step);
}

}  // namespace graintruth::app
