// The parameters with their intervals, beside what the bench said and where the search was allowed
// to look.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "datasets/parameters/parameter.h"
#include "reports/page/parameter_words.h"
#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

std::string range_text(double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return std::string(nothing);
  return plain(lower) + " to " + plain(upper);
}

std::string unit_of(const Json& parameter) { return unit_text(text(parameter, {"unit"})); }

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
  TableView table("Parameters",
                  {{"Parameter", Align::left},
                   {"Value"},
                   {"95 % interval"},
                   {"Unit", Align::left},
                   {"Status", Align::left},
                   {"Bench value"}});
  for (const auto& [key, parameter] : parameters.items()) {
    const std::string unit = unit_of(parameter);
    table.add_row({parameter_name(key),
                   value_text(parameter),
                   interval_of(parameter),
                   unit.empty() ? "-" : unit,
                   status_words(parameter),
                   bench_text(parameter)});
  }
  return table;
}

// What each status means, of those that stand in the table.
std::vector<std::string> status_sentences(const Json& parameters) {
  std::vector<std::string> all;
  for (const auto& [key, parameter] : parameters.items()) {
    const std::string words = status_words(parameter);
    if (words == "not identified") {
      add_once(all,
               "Not identified: these data do not determine the parameter. It is held at its bench "
               "value or, where that fits worse, at the value that fits best.");
    } else if (words == "budget ended") {
      add_once(all,
               "Budget ended: the search ended before the interval was found. This is no word of "
               "the data.");
    } else if (words.starts_with("open")) {
      add_once(all, "Open: every value up to that bound of the search fits as well.");
    } else if (words == "at bound") {
      add_once(all, "At bound: the search ended at the edge of its range, so widen the range.");
    }
  }
  return all;
}

TableView knowledge_table(const Json& parameters) {
  TableView table("What the search knew and learnt of each parameter",
                  {{"Parameter", Align::left},
                   {"Prior"},
                   {"Search bounds"},
                   {"Range of objective"},
                   {"Noise of that"},
                   {"Sobol total"}});
  for (const auto& [key, parameter] : parameters.items()) {
    table.add_row(
        {parameter_name(key),
         prior_text(parameter),
         range_text(number(parameter, {"bound_lower"}), number(parameter, {"bound_upper"})),
         significant(number(parameter, {"objective_range"}), 2),
         significant(number(parameter, {"objective_range_of_noise"}), 2),
         decimal(number(parameter, {"sobol_total"}), 2)});
  }
  return table;
}

// What the bench measured beside what the films say.
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
    const double value = is_known ? number(films, {"value"}) : std::nan("");
    table.add_row({parameter_name(key),
                   bench_text(parameter),
                   is_known ? value_text(films) : std::string(nothing),
                   is_known ? interval_of(films) : std::string(nothing),
                   decimal(value / number(parameter, {"bench_value"}), 2),
                   decimal(number(parameter, {"bench_deviation"}), 1)});
  }
  section.add_table(table);
  section.add_paragraph(
      "Films alone: the value without any prior, or a dash where the films do not identify the "
      "parameter. Apart: the films' value less the bench value, divided by both standard "
      "uncertainties together (by that of the films, where the bench states none). Beyond 2, bench "
      "and films measure different things.");
  std::vector<std::string> reasons;
  for (const auto& [key, parameter] : parameters.items()) {
    const auto known = datasets::find_parameter(key);
    if (!known || known->kind->bench_differs.empty()) continue;
    add_once(reasons, std::string(known->kind->bench_differs));
  }
  if (!reasons.empty())
    section.add_paragraph(
        fmt::format("Why bench and films may differ: {}.", fmt::join(reasons, "; ")));
}

// Of the parameters in one unit.
Figure interval_figure(const Json& parameters, const std::string& unit) {
  FigureChoice choice;
  Json names = Json::array();
  std::vector<double> rows, values, bench;
  const auto bar = [&](const Json& parameter,
                       std::string_view from,
                       std::string_view to,
                       const char* name,
                       const char* colour,
                       double width) {
    const std::vector<double> ends = {number(parameter, {from}), number(parameter, {to})};
    if (!std::isfinite(ends[0]) || !std::isfinite(ends[1])) return;
    Json trace = line(ends, {rows.back(), rows.back()}, name, colour, width);
    trace["legendgroup"] = name;
    trace["showlegend"] =
        std::none_of(choice.traces.begin(), choice.traces.end(), [&](const Json& other) {
          return other["legendgroup"] == name;
        });
    choice.traces.push_back(trace);
  };
  std::vector<double> open_lower, open_lower_rows, open_upper, open_upper_rows;
  // An end that was not found stands at the bound of the search: an arrow leads on from there
  const auto mark_open_ends = [&](const Json& parameter) {
    const std::string text = interval_of(parameter);
    if (text.starts_with(nothing)) {
      open_lower.push_back(number(parameter, {"lower"}));
      open_lower_rows.push_back(rows.back());
    }
    if (text.ends_with(nothing)) {
      open_upper.push_back(number(parameter, {"upper"}));
      open_upper_rows.push_back(rows.back());
    }
  };
  for (const auto& [key, parameter] : parameters.items()) {
    if (unit_of(parameter) != unit) continue;
    rows.push_back(-static_cast<double>(rows.size()));  // downwards
    names.push_back(plot_text(parameter_name(key)));
    bar(parameter, "bound_lower", "bound_upper", "search bounds", "var(--faint)", 2.0);
    if (interval_of(parameter) != nothing) {
      bar(parameter, "lower", "upper", "95 % interval", "var(--measured-strong)", 12.0);
      mark_open_ends(parameter);
    }
    values.push_back(is_undetermined(parameter) ? std::nan("") : number(parameter, {"value"}));
    bench.push_back(number(parameter, {"bench_value"}));
  }
  choice.traces.push_back(
      points(bench, rows, "bench value", "var(--simulated)", "diamond-open", 11.0));
  choice.traces.back()["marker"]["line"] = {{"width", 2}};
  choice.traces.push_back(points(values, rows, "value", "var(--ink)", "circle", 6.0));
  bool is_first = true;
  const auto arrows = [&](const std::vector<double>& x,
                          const std::vector<double>& y,
                          const char* symbol) {
    if (x.empty()) return;
    choice.traces.push_back(points(x, y, "end not found", "var(--measured-strong)", symbol, 16.0));
    choice.traces.back()["showlegend"] = std::exchange(is_first, false);
  };
  arrows(open_lower, open_lower_rows, "triangle-left");
  arrows(open_upper, open_upper_rows, "triangle-right");
  return {.id = "parameter-intervals" + (unit.empty() ? "" : "-" + identifier(unit)),
          .caption =
              "A bench value far outside the interval means that bench test and films measure "
              "different things.",
          .height = 120 + 55 * static_cast<int>(rows.size()),
          .layout = {{"xaxis", axis(plot_text(value_axis(unit)), {{"rangemode", "tozero"}})},
                     {"yaxis",
                      {{"tickvals", plot_numbers(rows)},
                       {"ticktext", names},
                       {"range", {rows.back() - 0.6, 0.6}},
                       {"zeroline", false},
                       {"wrapticks", true},
                       {"showgrid", false}}}},
          .menu = "",
          .choices = {choice}};
}

void add_interval_figures(const Json& parameters, Section& section) {
  std::vector<std::string> units;
  for (const auto& [key, parameter] : parameters.items()) add_once(units, unit_of(parameter));
  for (const std::string& unit : units) section.add_figure(interval_figure(parameters, unit));
}

// How much of what was compared the emulator foresaw: 1 - (error/spread)^2, the predictivity Q2 of
// Marrel et al. (2008).
void add_emulator(const Json& result, Section& section) {
  const double error = number(result, {"emulator", "leave_one_out_error"});
  const double spread = number(result, {"emulator", "value_spread"});
  if (!(spread > 0.0)) return;
  section.add_paragraph(
      fmt::format("The emulator predicts all compared numbers and proposed where to simulate. It "
                  "predicts {:.0f} % "
                  "of their variance at parameter sets that it was not shown (leave-one-out).",
                  100.0 * std::max(0.0, 1.0 - (error / spread) * (error / spread))));
}

// What the surrogate says of the whole search box, and how well it is known.
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
    table.add_row({parameter_name(key),
                   to_interval(number(one, {"mean"}), lower, upper),
                   to_interval(number(one, {"standard_deviation"}), lower, upper),
                   interval_text(lower, upper)});
  }
  section.add_table(table);
  section.add_paragraph(fmt::format(
      "Drawn by random-walk Metropolis on the surrogate: {} effective draws. The surrogate "
      "predicts the logarithm of the objective with an error of {} (leave-one-out, root mean "
      "square). The standard deviation of that logarithm is {}. Between neighbouring parameter "
      "sets it is rough by {}. No value, score or interval on this page rests on the surrogate "
      "alone.",
      plain(std::round(number(posterior, {"effective_size"}))),
      significant(number(result, {"surrogate", "leave_one_out_error"}), 2),
      significant(number(result, {"surrogate", "value_spread"}), 2),
      significant(number(result, {"surrogate", "roughness"}), 2)));
  add_emulator(result, section);
}

// The evaluation that would have been best without one replicate or one particle.
void add_influence(const RunData& data, Section& section) {
  const auto rows = data.table("influence");
  if (!rows) return;
  const std::vector<std::string> parameters = columns_between(*rows, "left_out", "objective");
  std::vector<TableView::Column> columns = {{"Left out", Align::left}};
  for (const std::string& name : parameters) columns.push_back({parameter_axis(name)});
  columns.push_back({"Objective"});
  TableView table("The best of the evaluations when one replicate or particle is left out",
                  columns);
  for (std::size_t row = 0; row < rows->rows(); ++row) {
    std::vector<std::string> cells = {rows->text(row, "left_out")};
    for (const std::string& name : parameters)
      cells.push_back(significant(rows->number(row, name)));
    cells.push_back(significant(rows->number(row, "objective")));
    table.add_row(cells);
  }
  section.add_table(table);
  section.add_paragraph(
      "Nothing was simulated again for this table. The result rests on a single replicate or "
      "particle where a parameter leaves its interval without it.");
}

}  // namespace

Section parameters_section(const RunData& data, Section section) {
  const Json& parameters = at(data.result, {"parameters"});
  if (!parameters.is_object() || parameters.empty()) {
    section.add_absence("This run left no parameters behind.");
    return section;
  }
  section.add_table(parameter_table(parameters));
  const std::vector<std::string> statuses = status_sentences(parameters);
  if (!statuses.empty()) section.add_paragraph(fmt::format("{}", fmt::join(statuses, " ")));
  add_interval_figures(parameters, section);
  if (!data.is_calibration()) return section;
  section.begin_fold("How the parameters were found, and bench tests beside them");
  section.add_table(knowledge_table(parameters));
  section.add_paragraph(
      "Range of objective: the change of the objective when this parameter alone goes from its "
      "best value to the worse end of its range. Where it is not larger than its noise, the films "
      "cannot tell the parameter. Sobol total: the share of the objective\u2019s variation within "
      "the search bounds in which this parameter has a part.");
  for (const auto& [key, parameter] : parameters.items()) {
    const std::string method = text(parameter, {"method"});
    if (method.empty()) continue;
    section.add_paragraph("How the intervals were found: " + method + ".");
    break;
  }
  add_bench(parameters, section);
  add_posterior(data.result, section);
  add_influence(data, section);
  return section;
}

}  // namespace graintruth::reports
