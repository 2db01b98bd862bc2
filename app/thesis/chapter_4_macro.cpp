// Section 4.3 from printed data: the buttons, Beverloo's law, the t-tests, the kinematic model.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "app/thesis/button.h"
#include "app/thesis/printed_rates.h"
#include "app/thesis/targets.h"
#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/flow/beverloo.h"
#include "calibrate/flow/kinematic.h"

namespace graintruth::app {

namespace {

using calibrate::BeverlooLaw;
using calibrate::DischargeRate;
using calibrate::KinematicOptions;
using calibrate::TTest;

constexpr double gravity = 9.81;  // m/s2
const std::string properties = "table_4_3_macro_properties";
const std::string packing = "packing_and_flow";
const std::string experiment = "table_4_4_beverloo_experiment";
const std::string simulation = "table_4_5_beverloo_simulation";

double centimetre() { return unit_in_si("cm"); }

// d as section 4.3.2.5 prints and uses it for k, m.
double printed_diameter(const ThesisData& thesis) {
  return thesis.worded("table-4.3", "mean particle diameter").value() * centimetre();
}

double mean_of(std::span<const double> values) { return calibrate::summarise(values).mean; }

std::vector<double> printed_coefficients(const ThesisData& thesis, const std::string& name) {
  return thesis.table(name).numbers("C_printed");
}

std::vector<double> coefficients(std::span<const DischargeRate> rates, double k) {
  std::vector<double> values;
  for (const DischargeRate& rate : rates)
    values.push_back(calibrate::beverloo_coefficient(BeverlooLaw::slot, rate, k, gravity));
  return values;
}

// What Tables 4.4 and 4.5 have in common: C of eq 4.5 with k of the experiment, its average, and
// the solid fraction of the flowing bed.
void examine_coefficients(Examination& exam, const ThesisData& thesis, const std::string& name) {
  const datasets::Table& table = thesis.table(name);
  const double k = thesis.worded("fig-4.17", "experiment: k").value();
  const auto rates = printed_rates(thesis, name, button_diameter(thesis));
  const double solid = thesis.number(packing, "solid_areal_density");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string orifice = fmt::format("D = {} cm: ", table.text(row, "orifice_D_cm"));
    exam.take(orifice + "q", thesis.cell(name, row, "flow_rate_q_g_per_s", "g/s"));
    exam.take(orifice + "density", thesis.cell(name, row, "areal_density_rho_g_per_cm2", "g/cm2"));
    exam.compare(orifice + "C",
                 thesis.column_cell(name, row, "C_printed", "1/cm"),
                 calibrate::thesis_coefficient(rates[row], k, gravity),
                 "eq 4.5 as printed");
    exam.compare(orifice + "solid fraction, derived",
                 thesis.cell(name, row, "solid_fraction_rho_over_0.28898", "-"),
                 table.number(row, "areal_density_rho_g_per_cm2") / solid);
  }
  const std::vector<double> printed = printed_coefficients(thesis, name);
  exam.compare_worded("average of C", mean_of(printed), "of the printed C");
  exam.compare_worded(
      "average of C, without the d of eq 4.5",
      mean_of(coefficients(printed_rates(thesis, name, printed_diameter(thesis)), k)));
}

void compare_lines(Examination& exam,
                   const ThesisData& thesis,
                   const std::string& group,
                   const std::string& name) {
  const auto rates = printed_rates(thesis, name, button_diameter(thesis));
  const calibrate::BeverlooLine line = calibrate::fit_beverloo_line(BeverlooLaw::slot, rates);
  const double diameter = printed_diameter(thesis);
  exam.compare_worded(group + ": kd", line.zero / centimetre());
  exam.compare_worded(group + ": k", line.zero / diameter);
}

// k of a straight line through the orifices from 7.5 cm on.
double k_of_wide_orifices(const ThesisData& thesis, std::span<const std::string> names) {
  const double narrowest = thesis.worded("fig-4.17", "narrowest orifice without arches").value();
  std::vector<DischargeRate> wide;
  for (const std::string& name : names) {
    for (const DischargeRate& rate : printed_rates(thesis, name, button_diameter(thesis)))
      if (rate.orifice >= (narrowest - 1e-9) * centimetre()) wide.push_back(rate);
  }
  return calibrate::fit_beverloo_line(BeverlooLaw::slot, wide).zero / printed_diameter(thesis);
}

// How many values a group must have for t and P to round to what is printed.
std::vector<int> counts_that_fit(const calibrate::SampleSummary& first,
                                 const calibrate::SampleSummary& second,
                                 const Printed& t,
                                 const Printed& p) {
  std::vector<int> counts;
  for (int count = 3; count < 80; ++count) {
    calibrate::SampleSummary one = first, two = second;
    one.count = two.count = count;
    const TTest test = calibrate::welch_test(one, two);
    if (std::abs(test.t - t.value()) <= t.rounding() &&
        std::abs(test.p - p.value()) <= p.rounding())
      counts.push_back(count);
  }
  return counts;
}

// Standard deviation over mean of a profile across the bin.
double variation(const KinematicOptions& options, double B, double width) {
  constexpr int places = 2000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < places; ++i) {
    const double x = width * ((i + 0.5) / places - 0.5);
    const double v = calibrate::kinematic_velocity(options, B, 1.0, x);
    sum += v / places;
    squares += v * v / places;
  }
  return std::sqrt(squares - sum * sum) / sum;
}

// The argument at which a falling function has the given value.
double where_falling(const std::function<double(double)>& function, double value) {
  double low = 1e-4, high = 1.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    (function(middle) > value ? low : high) = middle;
  }
  return low;
}

}  // namespace

void examine_table_4_3(Examination& exam, const ThesisData& thesis) {
  const datasets::Table& table = thesis.table(properties);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    exam.take(table.text(row, "property"),
              thesis.cell(properties, row, "value", table.text(row, "unit")),
              table.text(row, "note"));
  }
  const Ellipse ellipse = button_ellipse(thesis);
  const double diameter = button_diameter(thesis);
  const double width = thesis.si(properties, "hopper_width");
  exam.compare_worded("mean particle diameter", diameter / centimetre(), "2 sqrt(ab), eq 4.6");
  exam.compare("major diameter",
               thesis.printed(properties, "semi_axis_a"),
               2.0 * ellipse.along / centimetre());
  exam.compare("minor diameter",
               thesis.printed(properties, "semi_axis_b"),
               2.0 * ellipse.across / centimetre());
  exam.compare("d/W", thesis.printed(packing, "d_over_W"), diameter / width);
  exam.compare(
      "aspect ratio", thesis.printed(packing, "aspect_ratio"), ellipse.along / ellipse.across);
  const datasets::Table& rates = thesis.table(experiment);
  double widest = 0.0;
  for (std::size_t row = 0; row < rates.rows(); ++row) {
    const double orifice = rates.number(row, "orifice_D_cm") * centimetre();
    widest = std::max(widest, orifice);
    exam.compare_worded(
        fmt::format("orifice of {} cm over the width", rates.text(row, "orifice_D_cm")),
        100.0 * orifice / width);
  }
  exam.compare_worded("fig 4.16: orifice of 5 cm in mean diameters",
                      rates.number(0, "orifice_D_cm") * centimetre() / diameter);
  exam.compare_worded("sec 4.3.2.4: smooth flow, diameters of the widest orifice",
                      widest / diameter);

  // What follows of the bed
  const double area = std::numbers::pi * ellipse.along * ellipse.across;
  const double mass = thesis.si(properties, "mass");
  const double areal = mass / area;
  const double count = thesis.number(properties, "number_of_particles");
  const double fraction = thesis.number(packing, "solid_fraction_experiment");
  const auto derived = [&](const char* quantity, double value) {
    exam.compare(std::string("derived: ") + quantity, thesis.printed(packing, quantity), value);
  };
  derived("solid_areal_density", areal / unit_in_si("g/cm2"));
  derived("areal_density_at_0.86", fraction * areal / unit_in_si("g/cm2"));
  derived("bed_height_at_0.86", count * area / (fraction * width) / centimetre());
  derived("bed_mass", count * mass / unit_in_si("g"));
}

void examine_table_4_4(Examination& exam, const ThesisData& thesis) {
  examine_coefficients(exam, thesis, experiment);
}

void examine_table_4_5(Examination& exam, const ThesisData& thesis) {
  examine_coefficients(exam, thesis, simulation);
  // With k of its own straight line
  const auto rates = printed_rates(thesis, simulation, printed_diameter(thesis));
  const double own =
      calibrate::fit_beverloo_line(BeverlooLaw::slot, rates).zero / printed_diameter(thesis);
  std::vector<double> values;
  for (const DischargeRate& rate : rates)
    values.push_back(calibrate::thesis_coefficient(rate, own, gravity));
  exam.compare_worded("average of C with the simulation's own k", mean_of(values));

  // Orifice by orifice beside the experiment
  const auto measured = printed_rates(thesis, experiment, 0.0);
  const auto simulated = printed_rates(thesis, simulation, 0.0);
  for (std::size_t i = 0; i < std::min(measured.size(), simulated.size()) && i < 2; ++i) {
    exam.compare_worded(fmt::format("sec 4.3.2.3: rate at D = {} cm against the experiment",
                                    thesis.table(simulation).text(i, "orifice_D_cm")),
                        100.0 * (simulated[i].rate / measured[i].rate - 1.0));
  }
  const auto of_wide = [&](const std::string& name) {
    const std::vector<double> all = printed_coefficients(thesis, name);
    return mean_of(std::span(all).subspan(2));
  };
  exam.compare_worded("sec 4.4: C of orifices from 7.5 cm on, simulation over experiment",
                      100.0 * (of_wide(simulation) / of_wide(experiment) - 1.0));
  const auto orifices = thesis.table(experiment).numbers("orifice_D_cm");
  exam.add_curve(
      {.id = "rates",
       .caption = "Flow rates that the thesis measured and simulated. Its simulation "
                  "falls behind at the two narrow orifices, where it arches.",
       .x_title = "Orifice (cm)",
       .y_title = "Rate (g/s)",
       .series = {{"experiment", orifices, thesis.table(experiment).numbers("flow_rate_q_g_per_s")},
                  {"simulation of the thesis",
                   orifices,
                   thesis.table(simulation).numbers("flow_rate_q_g_per_s")}}});
}

void examine_beverloo_lines(Examination& exam, const ThesisData& thesis) {
  compare_lines(exam, thesis, "experiment", experiment);
  compare_lines(exam, thesis, "simulation", simulation);
  const std::array both = {experiment, simulation};
  exam.compare_worded("k from 7.5 cm on: experiment",
                      k_of_wide_orifices(thesis, std::span(both).first(1)));
  exam.compare_worded("k from 7.5 cm on: simulation",
                      k_of_wide_orifices(thesis, std::span(both).last(1)));
  exam.compare_worded("k from 7.5 cm on: both pooled", k_of_wide_orifices(thesis, both));
  for (const std::string& name : both) {
    const auto rates = printed_rates(thesis, name, button_diameter(thesis));
    const calibrate::LeastSquaresFit fit =
        calibrate::fit_beverloo(BeverlooLaw::slot, rates, gravity);
    exam.add_note(fmt::format(
        "{}: C and k fitted together, without the d of eq 4.5: C = {:.3f} ± {:.3f}, k = {:.3f} ± "
        "{:.3f} (95 %), correlation {:.2f}.",
        name == experiment ? "Experiment" : "Simulation",
        fit.parameters[0],
        fit.half_width_95(0),
        fit.parameters[1],
        fit.half_width_95(1),
        fit.covariance(0, 1) / (fit.standard_error(0) * fit.standard_error(1))));
  }
}

void examine_table_4_6(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_4_6_ttest_C";
  const std::vector<double> measured = printed_coefficients(thesis, experiment);
  const std::vector<double> simulated = printed_coefficients(thesis, simulation);
  const calibrate::SampleSummary first = calibrate::summarise(measured);
  const calibrate::SampleSummary second = calibrate::summarise(simulated);
  exam.compare("experiment: mean", thesis.column_cell(name, 0, "mean_C", "1/cm"), first.mean);
  exam.compare("simulation: mean", thesis.column_cell(name, 1, "mean_C", "1/cm"), second.mean);
  exam.compare("experiment: standard deviation",
               thesis.cell(name, 0, "sd_C", "1/cm"),
               first.standard_deviation,
               "of the rounded C");
  exam.compare("simulation: standard deviation",
               thesis.cell(name, 1, "sd_C", "1/cm"),
               second.standard_deviation,
               "of the rounded C");
  const TTest welch = calibrate::welch_test(first, second);
  const TTest paired = calibrate::paired_test(measured, simulated);
  exam.compare("t value", thesis.cell(name, 0, "t_printed", "-"), welch.t);
  // The table prints two decimals of P, its column here lacks the last zero
  exam.compare_within("P value",
                      thesis.cell(name, 0, "P_printed", "-"),
                      welch.p,
                      thesis.worded("table-4.6", "P value").rounding(),
                      "Welch's test; pooled variances would print 0.89");
  const auto as_printed = [&](std::size_t row) {
    const datasets::Table& table = thesis.table(name);
    return calibrate::SampleSummary{
        table.number(row, "mean_C"), table.number(row, "sd_C"), table.integer(row, "n")};
  };
  exam.compare("P value of the printed means and deviations, derived",
               thesis.cell(name, 0, "P_welch_df4.30", "-"),
               calibrate::welch_test(as_printed(0), as_printed(1)).p);
  exam.compare("the same with pooled variances, derived",
               thesis.cell(name, 0, "P_pooled_df8", "-"),
               calibrate::pooled_test(as_printed(0), as_printed(1)).p);
  exam.add_note(fmt::format(
      "That no difference is found is no equivalence: the 95 % interval of the difference of C is "
      "{:.3f} to {:.3f}, a fifth of C. Paired by orifice t = {:.2f}, P = {:.2f}.",
      welch.lower,
      welch.upper,
      paired.t,
      paired.p));
}

void examine_table_4_7(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_4_7_ttest_velocity";
  const datasets::Table& table = thesis.table(name);
  // One value a particle's width
  const int bins =
      static_cast<int>(std::floor(thesis.si(properties, "hopper_width") / button_diameter(thesis)));
  const auto group = [&](std::size_t row) {
    return calibrate::SampleSummary{table.number(row, "mean_velocity_m_per_s_unit_inferred"),
                                    table.number(row, "sd_velocity_m_per_s_unit_inferred"),
                                    bins};
  };
  for (std::size_t row = 0; row + 1 < table.rows(); row += 2) {
    const std::string orifice = fmt::format("D = {} cm: ", table.text(row, "orifice_D_cm"));
    const TTest test = calibrate::welch_test(group(row), group(row + 1));
    const Printed t = thesis.column_cell(name, row, "t_printed", "-");
    const Printed p = thesis.column_cell(name, row, "P_printed", "-");
    for (const std::size_t of : {row, row + 1}) {
      exam.take(orifice + table.text(of, "group") + ", standard deviation",
                thesis.cell(name, of, "sd_velocity_m_per_s_unit_inferred", "m/s"));
    }
    exam.compare(orifice + "t value", t, test.t, fmt::format("n = {}", bins));
    exam.compare(orifice + "P value", p, test.p, fmt::format("n = {}", bins));
    exam.add_note(fmt::format("{}t and P are printed so for n = {} values a group.",
                              orifice,
                              fmt::join(counts_that_fit(group(row), group(row + 1), t, p), ", ")));
  }
  // Mass balance: mean speed = q / (rho W)
  const double width = thesis.si(properties, "hopper_width");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& group_name = table.text(row, "group");
    const double orifice = table.number(row, "orifice_D_cm") * centimetre();
    for (const DischargeRate& rate :
         printed_rates(thesis, group_name == "experiment" ? experiment : simulation, 0.0)) {
      if (std::abs(rate.orifice - orifice) > 1e-9) continue;
      exam.compare(
          fmt::format("D = {} cm: {}, mean speed", table.text(row, "orifice_D_cm"), group_name),
          thesis.cell(name, row, "mean_velocity_m_per_s_unit_inferred", "m/s"),
          -rate.rate / (rate.density * width));
    }
  }
}

void examine_kinematic(Examination& exam, const ThesisData& thesis) {
  const std::string name = "kinematic_fit";
  const std::string velocities = "table_4_7_ttest_velocity";
  const datasets::Table& table = thesis.table(name);
  const double width = thesis.si(properties, "hopper_width");
  const double diameter = printed_diameter(thesis);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string which =
        fmt::format("D = {} cm, {}: ", table.text(row, "orifice_D_cm"), table.text(row, "group"));
    const Printed printed = thesis.cell(name, row, "B_over_d_printed", "d");
    const double B = printed.value() * diameter;
    const double height = table.number(row, "height_h_cm") * centimetre();
    const KinematicOptions point{.height = height};
    exam.compare(which + "deviation over mean of its profile, derived",
                 thesis.cell(name, row, "velocity_cv_of_fitted_profile", "-"),
                 variation(point, B, width));
    const datasets::Table& measured = thesis.table(velocities);
    const double wanted = measured.number(row, "sd_velocity_m_per_s_unit_inferred") /
                          std::abs(measured.number(row, "mean_velocity_m_per_s_unit_inferred"));
    exam.compare(
        which + "B, by the deviation of Table 4.7",
        printed,
        where_falling([&](double tried) { return variation(point, tried, width); }, wanted) /
            diameter);
    // The same curve with an orifice of its true width
    const KinematicOptions finite{.height = height,
                                  .orifice = table.number(row, "orifice_D_cm") * centimetre()};
    std::vector<calibrate::VelocitySample> curve;
    constexpr int half = 50;
    for (int i = -half; i <= half; ++i) {
      const double x = 0.5 * width * i / half;
      curve.push_back({x, calibrate::kinematic_velocity(point, B, 1.0, x), 0.0});
    }
    exam.compare(which + "B, by an orifice of finite width",
                 printed,
                 calibrate::fit_kinematic(curve, finite).B / diameter);
  }
}

}  // namespace graintruth::app
