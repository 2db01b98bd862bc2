// Section 4.3 simulated again: 200 buttons through five orifices, filled with and without friction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/thesis/button.h"
#include "app/thesis/macro_figures.h"
#include "app/thesis/printed_rates.h"
#include "app/thesis/targets.h"
#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/flow/beverloo.h"

namespace graintruth::app {

namespace {

constexpr double gravity = 9.81;      // m/s2
constexpr double significant = 0.05;  // P
const std::string packing = "packing_and_flow";
const std::string experiment = "table_4_4_beverloo_experiment";
const std::string simulation = "table_4_5_beverloo_simulation";

Simulated in_grams(Simulated simulated) {
  simulated.mean /= unit_in_si("g");
  simulated.spread /= unit_in_si("g");
  return simulated;
}

void examine_rates(Examination& exam,
                   const ThesisData& thesis,
                   const std::vector<OrificeRuns>& runs,
                   const std::string& filling) {
  const datasets::Table& table = thesis.table(experiment);
  const double tolerance = thesis.setting("macro", "rate_tolerance");
  const double wide = thesis.worded("fig-4.17", "narrowest orifice without arches").value();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double orifice = table.number(row, "orifice_D_cm");
    const Printed measured = thesis.cell(experiment, row, "flow_rate_q_g_per_s", "g/s");
    const Simulated rate = in_grams(runs[row].of("rate"));
    double pauses = 0.0;
    for (const double count : runs[row].values("pauses")) pauses += count;
    const std::string note = fmt::format(
        "the thesis simulated {} g/s; {} pauses in {} discharges, {} with a steady rate",
        thesis.table(simulation).text(row, "flow_rate_q_g_per_s"),
        pauses,
        runs[row].runs.size(),
        runs[row].values("rate").size());
    const std::string where =
        fmt::format("{}, D = {} cm: rate of the experiment", filling, orifice);
    if (orifice >= wide) {
      exam.claim_value(where, measured, rate, tolerance * measured.value(), note);
    } else {
      exam.claim(
          fmt::format("{}, D = {} cm: simulation slower than the experiment", filling, orifice),
          measured,
          rate,
          no_number,
          rate.mean < measured.value(),
          note);
    }
  }
}

// Our mean rates; densities are those of our flowing beds. Orifices with one steady rate or none
// are left out.
std::vector<calibrate::DischargeRate> rates_of(const ThesisData& thesis,
                                               const std::vector<OrificeRuns>& runs) {
  std::vector<calibrate::DischargeRate> rates;
  for (const OrificeRuns& of : runs) {
    const Simulated rate = of.of("rate");
    if (of.values("rate").size() < 2) continue;
    rates.push_back({.orifice = of.orifice,
                     .rate = rate.mean,
                     .density = of.of("density").mean,
                     .particle_diameter = button_diameter(thesis),
                     .standard_uncertainty = rate.spread / std::sqrt(rate.seeds)});
  }
  return rates;
}

// C and k of our rates, fitted together.
std::string fit_sentence(const ThesisData& thesis,
                         const std::vector<OrificeRuns>& runs,
                         const std::string& filling) {
  const auto rates = rates_of(thesis, runs);
  if (rates.size() < 3) return filling + ": too few steady rates for a fit of C and k.";
  const auto fit = calibrate::fit_beverloo(calibrate::BeverlooLaw::slot, rates, gravity);
  const auto line = calibrate::fit_beverloo_line(calibrate::BeverlooLaw::slot, rates);
  return fmt::format(
      "Filled with {}: C and k fitted together to our rates: C = {:.3f} ± {:.3f}, k = {:.2f} ± "
      "{:.2f} (95 %); k of the straight line {:.2f}.",
      filling,
      fit.parameters[0],
      fit.half_width_95(0),
      fit.parameters[1],
      fit.half_width_95(1),
      line.zero / button_diameter(thesis));
}

// Of all fillings of the orifices from the narrowest one without arches on.
std::vector<double> wide_values(const ThesisData& thesis,
                                const std::vector<OrificeRuns>& runs,
                                const char* key) {
  const double wide =
      thesis.worded("fig-4.17", "narrowest orifice without arches").value() * unit_in_si("cm");
  std::vector<double> values;
  for (const OrificeRuns& of : runs) {
    if (of.orifice < wide - 1e-9) continue;
    for (const double value : of.values(key)) values.push_back(value);
  }
  return values;
}

// Figures 4.12 and 4.13: the bed loosens when it flows, the more the wider the orifice, and arches
// where it is narrow.
void examine_flowing_beds(Examination& exam,
                          const ThesisData& thesis,
                          const std::vector<OrificeRuns>& runs,
                          const std::string& filling) {
  const Simulated flowing = over_seeds(wide_values(thesis, runs, "flowing_fraction"));
  const Simulated rest = over_seeds(wide_values(thesis, runs, "fraction"));
  exam.claim(filling + ": the bed is less dense in flow than at rest",
             {"dilated", "-", "sec 4.3.2.2"},
             flowing,
             no_number,
             flowing.mean < rest.mean - std::hypot(flowing.spread, rest.spread),
             fmt::format("solid fraction, orifices without arches; at rest {:.3f}", rest.mean));
  const datasets::Table& table = thesis.table(experiment);
  double measured = 0.0, orifices = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.number(row, "orifice_D_cm") <
        thesis.worded("fig-4.17", "narrowest orifice without arches").value() - 1e-9)
      continue;
    measured += table.number(row, "solid_fraction_rho_over_0.28898");
    ++orifices;
  }
  measured /= orifices;
  exam.claim(
      filling + ": in flow the simulated bed is less dense than the experiment's",
      {"less dense", "-", "sec 4.3.2.2"},
      flowing,
      no_number,
      flowing.mean < measured,
      fmt::format("solid fraction, orifices without arches; the experiment's {:.3f}", measured));
  const std::vector<double> narrow = runs.front().values("flowing_fraction");
  const std::vector<double> wide = runs.back().values("flowing_fraction");
  if (narrow.size() >= 2 && wide.size() >= 2) {
    const calibrate::TTest test =
        calibrate::welch_test(calibrate::summarise(wide), calibrate::summarise(narrow));
    exam.claim(filling + ": the wider the orifice the less dense the flowing bed",
               {"reduced", "-", "sec 4.3.2.2"},
               over_seeds(wide),
               no_number,
               test.upper < 0.0,
               fmt::format("solid fraction, D = {} cm; with D = {} cm {:.3f}, difference {:+.3f} "
                           "({:+.3f} to {:+.3f})",
                           runs.back().label,
                           runs.front().label,
                           calibrate::summarise(narrow).mean,
                           test.difference,
                           test.lower,
                           test.upper));
  } else {
    exam.not_run(filling + ": the wider the orifice the less dense the flowing bed",
                 {"reduced", "-", "sec 4.3.2.2"},
                 "too few discharges through the narrowest orifice were steady");
  }
  const Simulated of_narrow = runs.front().of("arches"), of_wide = runs.back().of("arches");
  const auto standard_error = [](const Simulated& of) { return of.spread / std::sqrt(of.seeds); };
  exam.claim(
      filling + ": more arches the narrower the orifice",
      {"more frequent", "-", "sec 4.3.2.3"},
      of_narrow,
      no_number,
      of_narrow.mean - of_wide.mean >
          2.0 * std::hypot(standard_error(of_narrow), standard_error(of_wide)),
      fmt::format("arches a discharge, those included that stayed, D = {} cm; with D = {} cm "
                  "{:.1f}; by more than two standard errors",
                  runs.front().label,
                  runs.back().label,
                  of_wide.mean));
}

// Like Table 4.6: C of ours beside the experiment's, each orifice one value, at the experiment's k.
void compare_coefficients(Examination& exam,
                          const ThesisData& thesis,
                          const std::vector<OrificeRuns>& runs,
                          const std::string& filling) {
  const double k = thesis.worded("fig-4.17", "experiment: k").value();
  const auto coefficients = [&](const std::vector<calibrate::DischargeRate>& rates) {
    std::vector<double> values;
    for (const calibrate::DischargeRate& rate : rates)
      values.push_back(
          calibrate::beverloo_coefficient(calibrate::BeverlooLaw::slot, rate, k, gravity));
    return values;
  };
  const std::vector<double> ours = coefficients(rates_of(thesis, runs));
  const std::string where = filling + ", like Table 4.6: P that C differs from the experiment's";
  const Printed printed = thesis.worded("table-4.6", "P value");
  if (ours.size() < 3) {
    exam.not_run(where, printed, "too few steady rates");
    return;
  }
  const std::vector<double> theirs =
      coefficients(printed_rates(thesis, experiment, button_diameter(thesis)));
  const calibrate::TTest test =
      calibrate::welch_test(calibrate::summarise(ours), calibrate::summarise(theirs));
  exam.claim(where,
             printed,
             {.mean = test.p, .seeds = static_cast<int>(ours.size())},
             no_number,
             test.p > significant,
             fmt::format("no significant difference was claimed; C without d at k = {:.2f}: ours "
                         "{:.3f}, the experiment's {:.3f}, difference {:+.3f} ({:+.3f} to {:+.3f})",
                         k,
                         calibrate::summarise(ours).mean,
                         calibrate::summarise(theirs).mean,
                         test.difference,
                         test.lower,
                         test.upper));
}

// Like Table 4.7 and figure 4.18: velocities across the bin, and B of them.
void compare_profiles(Examination& exam,
                      const ThesisData& thesis,
                      const std::vector<OrificeRuns>& runs,
                      const std::string& filling) {
  const std::string velocities = "table_4_7_ttest_velocity", fits = "kinematic_fit";
  const datasets::Table& printed = thesis.table(velocities);
  for (std::size_t row = 0; row < printed.rows(); ++row) {
    const auto of = std::find_if(runs.begin(), runs.end(), [&](const OrificeRuns& one) {
      return one.label == printed.text(row, "orifice_D_cm");
    });
    const std::string where = fmt::format("{}, D = {} cm", filling, of->label);
    if (printed.text(row, "group") == "experiment") {
      std::vector<double> ours;
      for (const double velocity : of->band("velocity").mean)
        if (std::isfinite(velocity)) ours.push_back(velocity);
      if (ours.size() < 3) continue;
      const calibrate::SampleSummary own = calibrate::summarise(ours);
      const calibrate::TTest test =
          calibrate::welch_test(own,
                                {-printed.number(row, "mean_velocity_m_per_s_unit_inferred"),
                                 printed.number(row, "sd_velocity_m_per_s_unit_inferred"),
                                 own.count});
      exam.claim(where + ", like Table 4.7: P that velocities differ from the experiment's",
                 thesis.column_cell(velocities, row, "P_printed", "-"),
                 {.mean = test.p, .seeds = own.count},
                 no_number,
                 test.p > significant,
                 fmt::format("no significant difference was claimed; means over {} places {:.3f} "
                             "and {:.3f} m/s, difference {:+.3f} ({:+.3f} to {:+.3f}): a test that "
                             "hardly sees anything",
                             own.count,
                             own.mean,
                             -printed.number(row, "mean_velocity_m_per_s_unit_inferred"),
                             test.difference,
                             test.lower,
                             test.upper));
      continue;
    }
    const Printed B = thesis.cell(fits, row, "B_over_d_printed", "d");
    const auto in_diameters = [&](const char* key) {
      Simulated found = of->of(key);
      found.mean /= button_diameter(thesis);
      found.spread /= button_diameter(thesis);
      return found;
    };
    exam.claim_value(where + ": B of the velocity profile",
                     B,
                     in_diameters("B"),
                     thesis.setting("macro", "kinematic_tolerance") * B.value(),
                     fmt::format("the thesis's form, velocity of the middle kept; by an orifice of "
                                 "its width {:.2f} d",
                                 in_diameters("B_finite").mean));
  }
}

}  // namespace

void simulate_macro(Examination& exam, const ThesisData& thesis, Studies& studies) {
  MacroRuns runs;
  runs.with_friction = run_bins(thesis, studies, false);
  runs.without_friction = run_bins(thesis, studies, true);

  // 1. Solid fraction at rest, over all orifices: the bed does not know of them yet
  const auto fractions = [](const std::vector<OrificeRuns>& all) {
    std::vector<double> values;
    for (const OrificeRuns& of : all) {
      for (const double value : of.values("fraction")) values.push_back(value);
    }
    return over_seeds(values);
  };
  const double tolerance = thesis.setting("macro", "fraction_tolerance");
  const Simulated with = fractions(runs.with_friction);
  const Simulated without = fractions(runs.without_friction);
  exam.claim_value("solid fraction, filled with friction",
                   thesis.printed(packing, "solid_fraction_simulation_friction_filled"),
                   with,
                   tolerance);
  exam.claim_value("solid fraction, filled without friction",
                   thesis.printed(packing, "solid_fraction_simulation_frictionless_filled"),
                   without,
                   tolerance);
  exam.claim("a bed filled without friction is denser",
             {"denser", "-", "sec 4.3.2.1"},
             without,
             no_number,
             without.mean > with.mean + std::hypot(with.spread, without.spread),
             fmt::format("solid fraction; with friction {:.3f}", with.mean));

  // 2. Rates, flowing beds and profiles
  for (const auto& [filling, of] : {std::pair("friction", &runs.with_friction),
                                    std::pair("frictionless", &runs.without_friction)}) {
    examine_rates(exam, thesis, *of, filling);
    examine_flowing_beds(exam, thesis, *of, filling);
    compare_coefficients(exam, thesis, *of, filling);
    compare_profiles(exam, thesis, *of, filling);
  }
  exam.add_note(fit_sentence(thesis, runs.with_friction, "friction"));
  exam.add_note(fit_sentence(thesis, runs.without_friction, "no friction"));
  draw_bins(exam, thesis, runs);
}

}  // namespace graintruth::app
