#include "app/thesis/macro_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/thesis/button.h"
#include "calibrate/flow/beverloo.h"
#include "calibrate/flow/kinematic.h"

namespace graintruth::app {

namespace {

using Numbers = std::vector<double>;

const std::string experiment = "table_4_4_beverloo_experiment";
const std::string simulation = "table_4_5_beverloo_simulation";
const std::string experiment_name = "experiment of the thesis";
const std::string simulation_name = "simulation of the thesis";

struct Filling {
  const char* name;
  const std::vector<OrificeRuns>* runs;
};
std::vector<Filling> fillings_of(const MacroRuns& runs) {
  return {{"ours, filled with friction", &runs.with_friction},
          {"ours, filled without friction", &runs.without_friction}};
}

Numbers scaled(Numbers values, double unit) {
  for (double& value : values) value /= unit;
  return values;
}

Series band_of(const OrificeRuns& runs, const char* x, const char* y, double unit) {
  const OrificeRuns::Band band = runs.band(y);
  return {.x = runs.band(x).mean,
          .y = scaled(band.mean, unit),
          .spread = scaled(band.spread, unit),
          .is_ours = true,
          .is_line = true};
}

Curve by_orifice(std::string id, std::string caption, std::string x_title, std::string y_title) {
  return {.id = std::move(id),
          .caption = std::move(caption),
          .x_title = std::move(x_title),
          .y_title = std::move(y_title),
          .menu = "Orifice"};
}

std::string choice_of(const OrificeRuns& runs) { return runs.label + " cm"; }

// Figure 4.12a.
Curve fractions_in_time(const MacroRuns& runs) {
  Curve curve = by_orifice("macro-fraction-time",
                           "Solid fraction of the bed as it runs out (fig. 4.12a), until four "
                           "fifths have left; mean and standard deviation over fillings.",
                           "Time since the opening (s)",
                           "Solid fraction");
  for (const Filling& filling : fillings_of(runs)) {
    for (const OrificeRuns& of : *filling.runs) {
      Series series = band_of(of, "time", "solid_fraction", 1.0);
      series.name = filling.name;
      series.choice = choice_of(of);
      curve.series.push_back(std::move(series));
    }
  }
  return curve;
}

// A quantity of every filling against the orifice. The two are drawn a little aside of each other.
void add_ours(const MacroRuns& runs, const char* key, double unit, Curve& curve) {
  constexpr double aside = 0.06;  // cm
  double shift = -aside;
  for (const Filling& filling : fillings_of(runs)) {
    Series series{.name = filling.name, .is_ours = true};
    for (const OrificeRuns& of : *filling.runs) {
      const Simulated found = of.of(key);
      series.x.push_back(of.orifice / unit_in_si("cm") + shift);
      series.y.push_back(found.mean / unit);
      series.spread.push_back(found.spread / unit);
    }
    curve.series.push_back(std::move(series));
    shift += 2.0 * aside;
  }
}

// What the thesis prints of both its groups in a column of Tables 4.4 and 4.5, and ours, against
// the orifice.
Curve against_orifice(const ThesisData& thesis,
                      const MacroRuns& runs,
                      const char* column,
                      const char* key,
                      double unit,
                      Curve curve) {
  curve.x_title = "Orifice (cm)";
  for (const auto& [name, table] :
       {std::pair(experiment_name, experiment), std::pair(simulation_name, simulation)}) {
    curve.series.push_back({.name = name,
                            .x = thesis.table(table).numbers("orifice_D_cm"),
                            .y = thesis.table(table).numbers(column)});
  }
  add_ours(runs, key, unit, curve);
  return curve;
}

// Figure 4.13. Of the experiment the thesis prints the rate alone.
Curve discharges(const ThesisData& thesis, const MacroRuns& runs) {
  Curve curve = by_orifice(
      "macro-discharge",
      "Mass that has left (figs. 4.13 and 4.14): mean and standard deviation over fillings. Of the "
      "experiment the thesis prints only the steady rate, drawn as a slope from the origin.",
      "Time since the opening (s)",
      "Discharged (g)");
  const datasets::Table& table = thesis.table(experiment);
  for (std::size_t row = 0; row < runs.with_friction.size(); ++row) {
    const double rate = table.number(row, "flow_rate_q_g_per_s");
    const double bed = thesis.number("packing_and_flow", "bed_mass");
    curve.series.push_back({.name = "steady rate of the experiment",
                            .x = {0.0, 0.5 * bed / rate},
                            .y = {0.0, 0.5 * bed},
                            .is_line = true,
                            .choice = choice_of(runs.with_friction[row])});
    for (const Filling& filling : fillings_of(runs)) {
      Series series = band_of((*filling.runs)[row], "time", "discharged", unit_in_si("g"));
      series.name = filling.name;
      series.choice = choice_of((*filling.runs)[row]);
      curve.series.push_back(std::move(series));
    }
  }
  return curve;
}

// Figure 4.17: rates as the thesis draws them, each with its straight line.
Curve beverloo_lines(const ThesisData& thesis, const MacroRuns& runs) {
  Curve curve{.id = "macro-beverloo",
              .caption =
                  "Rates to the power of 2/3 against the orifice with straight lines "
                  "through them (fig. 4.17); a line meets the axis at kd.",
              .x_title = "Orifice (cm)",
              .y_title = "(g/s)^(2/3)"};
  const auto add = [&](const std::string& name, const Numbers& orifices, const Numbers& grams) {
    Series dots{.name = name}, line{.name = name, .is_line = true, .belongs_to_last = true};
    std::vector<calibrate::DischargeRate> of_line;
    for (std::size_t i = 0; i < orifices.size(); ++i) {
      if (!std::isfinite(grams[i])) continue;
      dots.x.push_back(orifices[i]);
      dots.y.push_back(std::cbrt(grams[i] * grams[i]));
      of_line.push_back(
          {.orifice = orifices[i] * unit_in_si("cm"), .rate = grams[i] * unit_in_si("g")});
    }
    dots.is_ours = line.is_ours = name.starts_with("ours");
    if (of_line.size() >= 2) {
      const auto fit = calibrate::fit_beverloo_line(calibrate::BeverlooLaw::slot, of_line);
      const auto height = [&](double orifice) {
        const double rate = fit.slope * orifice * unit_in_si("cm") + fit.intercept;
        return rate / std::pow(unit_in_si("g"), 2.0 / 3.0);
      };
      line.x = {fit.zero / unit_in_si("cm"), dots.x.back()};
      line.y = {0.0, height(dots.x.back())};
    }
    curve.series.push_back(std::move(dots));
    if (!line.x.empty()) curve.series.push_back(std::move(line));
  };
  for (const auto& [name, table] :
       {std::pair(experiment_name, experiment), std::pair(simulation_name, simulation)}) {
    add(name,
        thesis.table(table).numbers("orifice_D_cm"),
        thesis.table(table).numbers("flow_rate_q_g_per_s"));
  }
  for (const Filling& filling : fillings_of(runs)) {
    Numbers orifices, grams;
    for (const OrificeRuns& of : *filling.runs) {
      orifices.push_back(of.orifice / unit_in_si("cm"));
      grams.push_back(of.of("rate").mean / unit_in_si("g"));
    }
    add(filling.name, orifices, grams);
  }
  return curve;
}

// The thesis's fitted profile: its B, and the velocity on the axis that gives its mean over the
// bin.
Series printed_profile(const ThesisData& thesis, std::size_t row, const std::string& choice) {
  const datasets::Table& fits = thesis.table("kinematic_fit");
  const double width = thesis.si("table_4_3_macro_properties", "hopper_width");
  const double B = fits.number(row, "B_over_d_printed") *
                   thesis.worded("table-4.3", "mean particle diameter").value() * unit_in_si("cm");
  const calibrate::KinematicOptions point{.height =
                                              fits.number(row, "height_h_cm") * unit_in_si("cm")};
  const double mean =
      -thesis.table("table_4_7_ttest_velocity").number(row, "mean_velocity_m_per_s_unit_inferred");
  Series series{.name = fits.text(row, "group") + " of the thesis, fitted",
                .is_line = true,
                .choice = choice};
  constexpr int places = 60;
  double sum = 0.0;
  for (int i = 0; i <= places; ++i) {
    const double x = width * (static_cast<double>(i) / places - 0.5);
    series.x.push_back(x / unit_in_si("cm"));
    series.y.push_back(calibrate::kinematic_velocity(point, B, 1.0, x));
    sum += series.y.back() / (places + 1);
  }
  for (double& velocity : series.y) velocity *= mean / sum;
  return series;
}

// Figure 4.18, of the orifices that the thesis shows.
Curve profiles(const ThesisData& thesis, const MacroRuns& runs) {
  Curve curve = by_orifice(
      "macro-profiles",
      fmt::format(
          "Downward velocity across the bin {} cm above the orifice (fig. 4.18): ours mean "
          "and standard deviation over fillings; of the thesis its fitted curves, scaled to "
          "the means of Table 4.7.",
          thesis.printed("packing_and_flow", "profile_band_height").text),
      "Place across the bin (cm)",
      "Downward velocity (m/s)");
  const datasets::Table& fits = thesis.table("kinematic_fit");
  for (const Filling& filling : fillings_of(runs)) {
    for (const OrificeRuns& of : *filling.runs) {
      bool is_shown = false;
      for (std::size_t row = 0; row < fits.rows(); ++row)
        is_shown |= fits.text(row, "orifice_D_cm") == of.label;
      if (!is_shown) continue;
      Series series = band_of(of, "x", "velocity", 1.0);
      series.x = scaled(series.x, unit_in_si("cm"));
      series.name = filling.name;
      series.is_line = false;
      series.choice = choice_of(of);
      curve.series.push_back(std::move(series));
    }
  }
  for (std::size_t row = 0; row < fits.rows(); ++row)
    curve.series.push_back(printed_profile(thesis, row, fits.text(row, "orifice_D_cm") + " cm"));
  return curve;
}

}  // namespace

void draw_bins(Examination& exam, const ThesisData& thesis, const MacroRuns& runs) {
  exam.add_curve(against_orifice(
      thesis,
      runs,
      "flow_rate_q_g_per_s",
      "rate",
      unit_in_si("g"),
      {.id = "macro-rates",
       .caption =
           "Flow rate against the orifice (fig. 4.15). Ours: mean and standard deviation over "
           "fillings, at the thesis's friction of 0.2; nothing was tuned.",
       .y_title = "Rate (g/s)"}));
  exam.add_curve(discharges(thesis, runs));
  exam.add_curve(fractions_in_time(runs));
  exam.add_curve(against_orifice(
      thesis,
      runs,
      "solid_fraction_rho_over_0.28898",
      "flowing_fraction",
      1.0,
      {.id = "macro-fraction-flow",
       .caption = "Solid fraction while the bed flows steadily (fig. 4.12b): mean and standard "
                  "deviation over fillings, and what the thesis's densities give.",
       .y_title = "Solid fraction"}));
  exam.add_curve(beverloo_lines(thesis, runs));
  exam.add_curve(profiles(thesis, runs));
}

}  // namespace graintruth::app
