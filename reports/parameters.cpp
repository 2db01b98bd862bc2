// The parameters with their intervals, beside what the bench said and where the search was allowed
// to look.
#include <fmt/format.h>

#include <cmath>

#include "reports/parameter_words.h"
#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

std::string range_text(double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return std::string(nothing);
  return plain(lower) + " to " + plain(upper);
}

std::string interval_text(double lower, double upper, int decimals) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return std::string(nothing);
  return decimal(lower, decimals) + " to " + decimal(upper, decimals);
}

std::string status_text(const std::string& status) {
  if (status == "at_bound") return "at bound";
  if (status == "not_identified") return "not identified";
  return status.empty() ? std::string(nothing) : status;
}

std::string unit_text(const Json& parameter) {
  const std::string unit = text(parameter, {"unit"});
  return unit.empty() || unit == "1" ? "-" : unit;
}

// "0.36 ± 0.03"; without the second where none is given.
std::string with_uncertainty(double value, double uncertainty) {
  return uncertainty > 0.0 ? plain(value) + " \u00b1 " + plain(uncertainty) : plain(value);
}

std::string bench_text(const Json& parameter) {
  return with_uncertainty(number(parameter, {"bench_value"}),
                          number(parameter, {"bench_standard_uncertainty"}));
}

std::string prior_text(const Json& parameter) {
  return with_uncertainty(number(parameter, {"prior", "mean"}),
                          number(parameter, {"prior", "standard_uncertainty"}));
}

// What the films say without any prior: a part of its own where there are priors.
const Json& films_alone(const Json& parameter) {
  const Json& alone = at(parameter, {"data_alone"});
  return alone.is_object() ? alone : parameter;
}

TableView parameter_table(const Json& parameters) {
  TableView table("Parameters, their intervals and where they come from",
                  {{"Parameter", Align::left},
                   {"Value"},
                   {"95 % interval"},
                   {"Unit", Align::left},
                   {"Status", Align::left},
                   {"Bench value"},
                   {"Prior"},
                   {"Search bounds"},
                   {"Range of objective"},
                   {"Noise of that"},
                   {"Sobol total"}});
  for (const auto& [key, parameter] : parameters.items()) {
    const double lower = number(parameter, {"lower"});
    const double upper = number(parameter, {"upper"});
    const int decimals = decimals_of_interval(lower, upper);
    const double low_bound = number(parameter, {"bound_lower"});
    const double high_bound = number(parameter, {"bound_upper"});
    table.add_row({parameter_name(key),
                   value_text(parameter),
                   interval_text(lower, upper, decimals),
                   unit_text(parameter),
                   status_text(text(parameter, {"status"})),
                   bench_text(parameter),
                   prior_text(parameter),
                   range_text(low_bound, high_bound),
                   significant(number(parameter, {"objective_range"}), 2),
                   significant(number(parameter, {"objective_range_of_noise"}), 2),
                   decimal(number(parameter, {"sobol_total"}), 2)});
  }
  return table;
}

// What the bench measured and what the films ask for.
void add_bench(const Json& parameters, Section& section) {
  TableView table("Bench tests beside the films",
                  {{"Parameter", Align::left},
                   {"Bench value"},
                   {"Films alone"},
                   {"Their 95 % interval"},
                   {"Films over bench"},
                   {"Apart (standard uncertainties)"}});
  for (const auto& [key, parameter] : parameters.items()) {
    const Json& films = films_alone(parameter);
    const bool is_known = std::isfinite(number(parameter, {"bench_deviation"}));
    const double lower = is_known ? number(films, {"lower"}) : std::nan("");
    const double upper = is_known ? number(films, {"upper"}) : std::nan("");
    const double value = is_known ? number(films, {"value"}) : std::nan("");
    const int decimals = decimals_of_interval(lower, upper);
    table.add_row({parameter_name(key),
                   bench_text(parameter),
                   decimal(value, decimals),
                   interval_text(lower, upper, decimals),
                   decimal(value / number(parameter, {"bench_value"}), 2),
                   decimal(number(parameter, {"bench_deviation"}), 1)});
  }
  section.add_table(table);
  section.add_paragraph(
      "Films alone: without any prior; a dash where they do not identify the parameter. Apart: "
      "the films' value less the bench value, over both standard uncertainties together (the "
      "films' only, where the bench states none); beyond 2 the two measure different things. "
      "Tilting measures static friction, films that of particles in motion, which is often well "
      "below it: the thesis tilted 0.36 and matched its films at 0.1 (section 4.2.2), and took "
      "0.2 for buttons that it had tilted at 0.61 (table 4.3).");
}

Figure interval_figure(const Json& parameters) {
  FigureChoice choice;
  Json names = Json::array();
  std::vector<double> rows;
  double row = static_cast<double>(parameters.size());
  bool first = true;
  std::vector<double> values;
  std::vector<double> value_rows;
  std::vector<double> bench;
  std::vector<double> bench_rows;
  const auto bar = [&](double from, double to, const char* name, const char* colour, double width) {
    if (!std::isfinite(from) || !std::isfinite(to)) return;
    Json trace = line({from, to}, {row, row}, name, colour, width);
    trace["legendgroup"] = name;
    trace["showlegend"] = first;
    choice.traces.push_back(trace);
  };
  for (const auto& [key, parameter] : parameters.items()) {
    names.push_back(plot_text(parameter_name(key)));
    rows.push_back(row);
    bar(number(parameter, {"bound_lower"}),
        number(parameter, {"bound_upper"}),
        "search bounds",
        "var(--faint)",
        2.0);
    bar(number(parameter, {"lower"}),
        number(parameter, {"upper"}),
        "95 % interval",
        "var(--measured-strong)",
        12.0);
    first = false;
    values.push_back(number(parameter, {"value"}));
    value_rows.push_back(row);
    bench.push_back(number(parameter, {"bench_value"}));
    bench_rows.push_back(row);
    row -= 1.0;
  }
  choice.traces.push_back(
      points(bench, bench_rows, "bench value", "var(--simulated)", "diamond-open", 11.0));
  choice.traces.back()["marker"]["line"] = {{"width", 2}};
  choice.traces.push_back(points(values, value_rows, "value", "var(--ink)", "circle", 6.0));
  return {.id = "parameter-intervals",
          .caption =
              "Each parameter's value with its interval, on the range that the search was allowed, "
              "beside the "
              "bench value: a bench value far outside the interval means that bench test and films "
              "measure "
              "different things.",
          .height = 120 + 55 * static_cast<int>(parameters.size()),
          .layout = {{"xaxis", axis("Value (dimensionless)", {{"rangemode", "tozero"}})},
                     {"yaxis",
                      {{"tickvals", plot_numbers(rows)},
                       {"ticktext", names},
                       {"range", {0.4, static_cast<double>(parameters.size()) + 0.6}},
                       {"wrapticks", true},
                       {"showgrid", false}}}},
          .menu = "",
          .choices = {choice}};
}

// How much of what was compared the emulator foresaw: 1 - (error/spread)^2, the predictivity Q2 of
// Marrel et al. (2008).
void add_emulator(const Json& result, Section& section) {
  const double error = number(result, {"emulator", "leave_one_out_error"});
  const double spread = number(result, {"emulator", "value_spread"});
  if (!(spread > 0.0)) return;
  section.add_paragraph(fmt::format(
      "The emulator of all compared numbers, which proposed where to simulate, foresees {:.0f} % "
      "of their variance at places that it was not shown (leave-one-out).",
      100.0 * std::max(0.0, 1.0 - (error / spread) * (error / spread))));
}

// What the surrogate makes of the whole landscape, and how far it can be trusted.
void add_posterior(const Json& result, Section& section) {
  const Json& posterior = at(result, {"posterior"});
  if (!posterior.is_object() || posterior.size() < 2) return;
  TableView table(
      "Posterior of the surrogate, beside the intervals above",
      {{"Parameter", Align::left}, {"Mean"}, {"Standard deviation"}, {"95 % credible"}});
  for (const auto& [key, one] : posterior.items()) {
    if (!one.is_object()) continue;
    const double lower = number(one, {"lower"});
    const double upper = number(one, {"upper"});
    const int decimals = decimals_of_interval(lower, upper);
    table.add_row({parameter_name(key),
                   decimal(number(one, {"mean"}), decimals),
                   decimal(number(one, {"standard_deviation"}), decimals),
                   interval_text(lower, upper, decimals)});
  }
  section.add_table(table);
  section.add_paragraph(fmt::format(
      "Drawn by random-walk Metropolis on the surrogate, {} effective draws. The surrogate knows "
      "the logarithm of the objective to {} (leave-one-out, root mean square), of a standard "
      "deviation of {}; from one place to the next the objective is rough by {}. No reported "
      "value, score or interval rests on the surrogate alone.",
      plain(std::round(number(posterior, {"effective_size"}))),
      significant(number(result, {"surrogate", "leave_one_out_error"}), 2),
      significant(number(result, {"surrogate", "value_spread"}), 2),
      significant(number(result, {"surrogate", "roughness"}), 2)));
  add_emulator(result, section);
}

// What would have been best without one replicate or one particle.
void add_influence(const RunData& data, Section& section) {
  const auto rows = data.table("influence");
  if (!rows) return;
  TableView table("The best of the evaluations when one replicate or particle is left out",
                  {{"Left out", Align::left},
                   {"Friction, particle to particle"},
                   {"Friction, particle to wall"},
                   {"Restitution"},
                   {"Objective"}});
  for (std::size_t row = 0; row < rows->rows(); ++row) {
    table.add_row({rows->text(row, "left_out"),
                   decimal(rows->number(row, "friction_particle_particle"), 3),
                   decimal(rows->number(row, "friction_particle_wall"), 3),
                   decimal(rows->number(row, "restitution"), 3),
                   significant(rows->number(row, "objective"), 3)});
  }
  section.add_table(table);
  section.add_paragraph(
      "Nothing was simulated anew for this table. Where leaving out a single one moves a parameter "
      "beyond its interval, the answer rests on that one.");
}

}  // namespace

Section parameters_section(const RunData& data, Section section) {
  const Json& parameters = at(data.result, {"parameters"});
  if (!parameters.is_object() || parameters.empty()) {
    section.add_absence("This run left no parameters behind.");
    return section;
  }
  section.add_table(parameter_table(parameters));
  section.add_paragraph(
      "Range of objective: how far the objective moves when this parameter alone goes from its "
      "best to the worse end of its range. Where that is no more than the noise of "
      "that range, the films cannot tell the parameter. Sobol total: the share of the "
      "objective\u2019s "
      "variation over the whole box of search bounds that this parameter takes part in.");
  for (const auto& [key, parameter] : parameters.items()) {
    const std::string method = text(parameter, {"method"});
    if (method.empty()) continue;
    section.add_paragraph("Intervals by " + method + ".");
    break;
  }
  section.add_figure(interval_figure(parameters));
  if (data.is_calibration()) add_bench(parameters, section);
  add_posterior(data.result, section);
  add_influence(data, section);
  return section;
}

}  // namespace graintruth::reports
