// Chapters 1 and 2 from printed data: the survey, the equations, the time step, the profile fit.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/thesis/button.h"
#include "app/thesis/targets.h"
#include "sim/laws/contact_law.h"
#include "sim/laws/material.h"
#include "sim/laws/restitution.h"
#include "sim/laws/time_step.h"

namespace graintruth::app {

namespace {

using std::numbers::pi;

// beta = -ln e / sqrt(ln^2 e + pi^2)   (1.20)
double damping_ratio(double restitution) {
  const double logarithm = std::log(restitution);
  return -logarithm / std::sqrt(logarithm * logarithm + pi * pi);
}

void examine_damping(Examination& exam, const ThesisData& thesis) {
  const std::string name = "derived_restitution";
  const datasets::Table& table = thesis.table(name);
  // Eq 1.21 lacks the sqrt(5/6) of 1.22: as 1.22 with a larger damping ratio
  const double without_factor = 1.0 / std::sqrt(5.0 / 6.0);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double wanted = table.number(row, "e_requested");
    const double beta = damping_ratio(wanted);
    const auto compare = [&](const char* column, const char* what, double value) {
      exam.compare(fmt::format("e = {}: {}", table.text(row, "e_requested"), what),
                   thesis.cell(name, row, column, "-"),
                   value);
    };
    compare("beta_eq_1_20", "damping ratio", beta);
    compare(
        "e_eq_1_22_unclipped", "e of eq 1.22", sim::restitution_of(beta, sim::Tension::allowed));
    compare("e_eq_1_22_clipped",
            "e of eq 1.22, force not below 0",
            sim::restitution_of(beta, sim::Tension::clipped));
    compare("e_eq_1_21_unclipped",
            "e of eq 1.21",
            sim::restitution_of(without_factor * beta, sim::Tension::allowed));
    compare("e_eq_1_21_clipped",
            "e of eq 1.21, force not below 0",
            sim::restitution_of(without_factor * beta, sim::Tension::clipped));
    const Printed clipped = thesis.cell(name, row, "beta_giving_e_when_clipped_eq_1_22", "-");
    if (clipped.text.empty()) continue;
    const auto ratio_for = [](double e) {
      return sim::damping_ratio_for(e, sim::Tension::clipped);
    };
    const double half = thesis.cell(name, row, "e_requested", "-").rounding();
    exam.compare_within(
        fmt::format("e = {}: damping ratio for it, force not below 0",
                    table.text(row, "e_requested")),
        clipped,
        ratio_for(wanted),
        clipped.rounding() + 0.5 * (ratio_for(wanted - half) - ratio_for(wanted + half)),
        "within the rounding of e");
  }
}

}  // namespace

void examine_table_1_1(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_1_1_shape_survey";
  const datasets::Table& table = thesis.table(name);
  double sum = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    exam.take(table.text(row, "particle_shape"),
              thesis.cell(name, row, "popularity_percent", "percent"));
    sum += table.number(row, "popularity_percent");
  }
  exam.compare_worded("sum of the shares", sum);
}

void examine_equations(Examination& exam, const ThesisData& thesis) {
  examine_damping(exam, thesis);
  exam.compare(
      "deck (f): damping ratio of the measured restitution",
      thesis.worded("equations", "deck (f): damping ratio of the measured restitution"),
      damping_ratio(thesis.number("table_4_1_micro_properties", "coefficient_of_restitution")));

  // E* of two bodies of one material: 1/E* = 2 (1 - nu^2)/E (1.5)
  const sim::Material button = button_material(thesis);
  const double mixed = sim::mix(button, button, {}, sim::Tension::allowed, 0.0).normal_modulus;
  const double eq_1_6 = button.youngs_modulus / (1.0 - button.poisson_ratio * button.poisson_ratio);
  exam.compare_worded("eq 1.6: E* over E/(1 - nu2)", mixed / eq_1_6);
  // F = (2/3) k_n d with the tangent stiffness k_n of 1.8
  const double overlap = 1e-6;  // m; the ratio does not depend on it
  const double stiffness = sim::hertz_stiffness(mixed, overlap);
  exam.compare_worded("eqs 1.72, 1.73: k_n d over the Hertz force",
                      stiffness * overlap / sim::hertz_force(stiffness, overlap));
  exam.compare_worded("eq 1.22: sqrt(5/6)", std::sqrt(5.0 / 6.0));
  // Leapfrog: dt < 2 sqrt(m/k), against the printed 2 pi sqrt(m/k)
  exam.compare_worded("eq 1.24: stable step over the printed one",
                      sim::stiffness_time_step(1.0, 1.0) / (2.0 * pi));
  // Two cosines uniform in [-1, 1] are possible where they lie in the unit circle
  exam.compare_worded("eq 2.33: share of draws without a root", 100.0 * (1.0 - pi / 4.0));
  // Rotation by atan(w dt) in place of w dt: (w dt)^2 / 3
  const std::string impulse = "ch3_rotation_translation";
  const double turn =
      thesis.number(impulse, "angular_velocity_theory") * thesis.number(impulse, "time_step");
  exam.compare_worded("eqs 2.24-2.31: relative error of a rotation", turn * turn / 3.0);
}

void examine_time_step(Examination& exam, const ThesisData& thesis) {
  const sim::Material button = button_material(thesis);
  const double density = button_density(thesis);
  const auto step = [&](double radius) { return sim::rayleigh_time_step(radius, density, button); };
  const double radius = thesis.setting("weight", "element_radius");
  const std::string without = "the same without the pi";
  const Printed critical = thesis.printed("ch3_misc", "critical_time_step");
  exam.compare("sec 3.2: critical time step, R = 1 cm", critical, step(radius));
  exam.compare("sec 3.2: " + without, critical, step(radius) / pi);

  const Printed steps = thesis.printed("packing_and_flow", "steps_per_frame");
  const double frame = thesis.number("packing_and_flow", "frame_period_that_reproduces_8843");
  const Printed smallest = thesis.printed("appendix_e", "R_s");
  const double element = smallest.value() * unit_in_si("cm");
  exam.compare("sec 4.3.1: steps of a frame", steps, frame / step(element));
  exam.compare_within("sec 4.3.1: " + without,
                      steps,
                      frame / (step(element) / pi),
                      frame / (step(element) / pi) * smallest.rounding() / smallest.value(),
                      "within the rounding of R = 0.433 cm; 25 frames/s");

  // The radius that the step of section 3.6 needs, R = dt psi sqrt(G/rho)
  const double impulse_step = thesis.si("ch3_rotation_translation", "time_step");
  exam.compare("sec 3.6: radius that its time step implies",
               thesis.printed("ch3_rotation_translation", "element_radius_implied"),
               impulse_step / (step(1.0) / pi) / unit_in_si("cm"),
               "eq 1.28 without the pi");
  exam.add_note(fmt::format(
      "The thesis's steps follow from eq 1.28 without its pi, for buttons of {:.1f} kg/m3: its "
      "fraction 1 is {:.3f} of Rayleigh's step.",
      density,
      1.0 / pi));
}

void examine_profile_fit(Examination& exam, const ThesisData& thesis) {
  const std::string name = "profile_fit_7_sphere";
  const datasets::Table& table = thesis.table(name);
  const sim::ProfileFit fit = button_fit(thesis);
  if (fit.spheres.size() != table.rows()) {
    exam.take("number of spheres", {"", "", ""}).verdict = Verdict::fail;
    return;
  }
  const double centimetre = unit_in_si("cm");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    exam.compare(fmt::format("sphere {}: radius", row + 1),
                 thesis.cell(name, row, "radius_cm", "cm"),
                 fit.spheres[row].radius / centimetre);
    exam.compare(fmt::format("sphere {}: distance of its centre", row + 1),
                 thesis.cell(name, row, "centre_from_centroid_cm", "cm"),
                 fit.spheres[row].centre.x() / centimetre);
  }
  exam.add_note(fmt::format(
      "Eight chords of {:.6f} cm on the ellipse with the semi-axes of Table 4.3; the spheres "
      "protrude by at most {:.4f} cm.",
      fit.chord / centimetre,
      fit.protrusion / centimetre));
}

}  // namespace graintruth::app
