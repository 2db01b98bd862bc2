// How the values were found: the evaluations in their order and in the plane of two parameters, and
// what the intervals rest on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "reports/page/parameter_words.h"
#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

struct Evaluations {
  struct Parameter {
    std::string name;
    std::vector<double> values;
  };
  std::vector<Parameter> varied;  // parameters that the search moved, in the order of the table
  std::vector<double> number, objective, best;
  std::vector<std::string> stage;
  std::vector<bool> failed;  // some of its simulations did not end well
  std::vector<double> failed_simulations;
  std::vector<std::string> stages;  // in order of appearance
};

Evaluations read_evaluations(const datasets::Table& table) {
  Evaluations all{.varied = {},
                  .number = column(table, "evaluation"),
                  .objective = column(table, "objective"),
                  .best = column(table, "best"),
                  .stage = text_column(table, "stage"),
                  .failed = {},
                  .failed_simulations = column(table, "failed"),
                  .stages = {}};
  for (const std::string& name : columns_between(table, "stage", "objective")) {
    std::vector<double> values = column(table, name);
    const bool varies = std::any_of(
        values.begin(), values.end(), [&](double value) { return value != values.front(); });
    if (varies) all.varied.push_back({name, std::move(values)});
  }
  for (std::size_t i = 0; i < table.rows(); ++i) {
    all.failed.push_back(all.failed_simulations[i] > 0.0 || !std::isfinite(all.objective[i]));
    add_once(all.stages, all.stage[i]);
  }
  return all;
}

std::string stage_colour(std::size_t stage) { return fmt::format("var(--stage{})", stage % 6); }

std::string stage_name(const std::string& stage) { return stage.empty() ? "evaluation" : stage; }

TableView stage_table(const Evaluations& all) {
  TableView table(
      "Evaluations by stage of the search",
      {{"Stage", Align::left}, {"Evaluations"}, {"Failed simulations"}, {"Lowest objective"}});
  double failed_in_all = 0.0;
  double lowest_of_all = std::nan("");
  for (const std::string& stage : all.stages) {
    double evaluations = 0.0;
    double failed = 0.0;
    double lowest = std::nan("");
    for (std::size_t i = 0; i < all.stage.size(); ++i) {
      if (all.stage[i] != stage) continue;
      evaluations += 1.0;
      if (all.failed_simulations[i] > 0.0) failed += all.failed_simulations[i];
      lowest = std::fmin(lowest, all.objective[i]);
    }
    failed_in_all += failed;
    lowest_of_all = std::fmin(lowest_of_all, lowest);
    table.add_row({stage_name(stage), count(evaluations), count(failed), significant(lowest, 4)});
  }
  table.add_total({"All",
                   count(static_cast<double>(all.stage.size())),
                   count(failed_in_all),
                   significant(lowest_of_all, 4)});
  return table;
}

Figure convergence_figure(const Evaluations& all) {
  FigureChoice choice;
  for (std::size_t s = 0; s < all.stages.size(); ++s) {
    std::vector<double> x;
    std::vector<double> y;
    for (std::size_t i = 0; i < all.stage.size(); ++i) {
      if (all.stage[i] != all.stages[s]) continue;
      x.push_back(all.number[i]);
      y.push_back(all.objective[i]);
    }
    choice.traces.push_back(points(x, y, stage_name(all.stages[s]), stage_colour(s)));
  }
  Json best = line(all.number, all.best, "best so far", "var(--ink)", 2.0);
  best["line"]["shape"] = "hv";
  choice.traces.push_back(best);
  Json ticks = Json::array();  // 1, 2 and 5 of every decade
  Json tick_texts = Json::array();
  for (int decade = -4; decade <= 4; ++decade) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const double tick = step * std::pow(10.0, decade);
      ticks.push_back(plot_numbers({tick}).front());
      tick_texts.push_back(plain(tick));
    }
  }
  return {.id = "search-convergence",
          .caption =
              "The objective of every evaluation, and the best so far. Where the line is flat long "
              "before the end, a larger budget would hardly have found a better value.",
          .height = 400,
          .layout = {{"xaxis", axis("Evaluation")},
                     {"yaxis",
                      axis("Objective",
                           {{"type", "log"}, {"tickvals", ticks}, {"ticktext", tick_texts}})}},
          .menu = "",
          .choices = {choice}};
}

// One axis of the plane, and where the result lies on it.
struct Side {
  std::string title;
  const std::vector<double>& values;
  double result;
  double lower, upper;  // of its interval; NaN where it has none
};

Side side_of(const RunData& data, const Evaluations::Parameter& parameter) {
  const Json& found = at(data.result, {"parameters", parameter.name});
  const bool has_interval = interval_of(found) != nothing;
  return {parameter_axis(parameter.name),
          parameter.values,
          number(found, {"value"}),
          has_interval ? number(found, {"lower"}) : std::nan(""),
          has_interval ? number(found, {"upper"}) : std::nan("")};
}

// The interval along one axis, as bars from the result.
Json bars(const Side& side) {
  return {{"type", "data"},
          {"symmetric", false},
          {"array", plot_numbers({side.upper - side.result})},
          {"arrayminus", plot_numbers({side.result - side.lower})},
          {"color", "var(--simulated)"},
          {"thickness", 3},
          {"width", 8}};
}

// The plane of the first two parameters that the search moved; of a single one, against the
// objective.
Figure plane_figure(const RunData& data, const Evaluations& all) {
  const bool is_of_one = all.varied.size() == 1;
  const Side across = side_of(data, all.varied[0]);
  const Side up = is_of_one ? Side{"Objective",
                                   all.objective,
                                   number(data.result, {"objective", "best"}),
                                   std::nan(""),
                                   std::nan("")}
                            : side_of(data, all.varied[1]);
  std::vector<double> x, y, objective, failed_x, failed_y;
  Json hover = Json::array();
  for (std::size_t i = 0; i < all.objective.size(); ++i) {
    if (all.failed[i]) {
      failed_x.push_back(across.values[i]);
      failed_y.push_back(up.values[i]);
    }
    if (!std::isfinite(all.objective[i])) continue;
    x.push_back(across.values[i]);
    y.push_back(up.values[i]);
    objective.push_back(all.objective[i]);
    hover.push_back(plot_text(fmt::format("evaluation {}, {}: objective {}",
                                          count(all.number[i]),
                                          stage_name(all.stage[i]),
                                          significant(all.objective[i], 4))));
  }
  FigureChoice choice;
  Json evaluated = points(x, y, "evaluated", "var(--muted)", "circle", 9.0);
  evaluated["text"] = hover;
  evaluated["hovertemplate"] = "%{x:.3f}, %{y:.3f}<br>%{text}<extra></extra>";
  evaluated["marker"]["color"] = plot_numbers(objective);
  evaluated["marker"]["colorscale"] = "Viridis";
  evaluated["marker"]["showscale"] = true;
  evaluated["marker"]["line"] = {{"width", 0.5}, {"color", "var(--muted)"}};
  evaluated["marker"]["colorbar"] = {{"title", {{"text", "objective"}, {"font", {{"size", 12}}}}},
                                     {"thickness", 12},
                                     {"outlinewidth", 0}};
  if (!objective.empty()) {
    // The scale ends at the upper quartile: the worst corner must not take the colours from the
    // valley.
    std::vector<double> sorted = objective;
    std::sort(sorted.begin(), sorted.end());
    evaluated["marker"]["cmin"] = sorted.front();
    evaluated["marker"]["cmax"] = sorted[(sorted.size() - 1) * 3 / 4];
  }
  choice.traces.push_back(evaluated);
  if (!failed_x.empty())
    choice.traces.push_back(
        points(failed_x, failed_y, "with failed simulations", "var(--simulated)", "x", 7.0));
  if (std::isfinite(across.result) && std::isfinite(up.result)) {
    const bool has_bars = std::isfinite(across.lower) || std::isfinite(up.lower);
    Json best = points({across.result},
                       {up.result},
                       has_bars ? "result, 95 % intervals" : "result",
                       "rgba(0,0,0,0)",
                       "star",
                       17.0);
    best["marker"]["line"] = {{"width", 2}, {"color", "var(--simulated)"}};
    if (std::isfinite(across.lower)) best["error_x"] = bars(across);
    if (std::isfinite(up.lower)) best["error_y"] = bars(up);
    choice.traces.push_back(best);
  }
  return {
      .id = "search-plane",
      .caption = fmt::format(
          "Every evaluation of the search, dark where the simulation fits well.{}{}",
          is_of_one ? ""
                    : " A long dark valley means that one of the two parameters can make up for "
                      "the other.",
          all.varied.size() > 2
              ? fmt::format(" The search moved {} parameters; the plane shows the first two.",
                            all.varied.size())
              : ""),
      .height = 480,
      .layout = {{"xaxis", axis(plot_text(across.title))}, {"yaxis", axis(plot_text(up.title))}},
      .menu = "",
      .choices = {choice}};
}

struct Profile {
  std::string name;
  std::vector<double> values, excesses;
};

// The profiles of the parameters in one unit.
Figure profile_figure(const Json& parameters,
                      const std::vector<Profile>& profiles,
                      const std::string& unit,
                      bool has_limit) {
  FigureChoice choice;
  std::size_t colour = 0;
  double lowest = std::nan(""), highest = lowest;
  for (const auto& [name, values, excesses] : profiles) {
    if (parameter_unit(name) != unit) continue;
    Json trace = points(values, excesses, parameter_name(name), stage_colour(++colour));
    trace["mode"] = "lines+markers";
    choice.traces.push_back(trace);
    const Json& parameter = at(parameters, {name});
    if (has_limit && interval_of(parameter) != nothing) {
      Json interval = line({number(parameter, {"lower"}), number(parameter, {"upper"})},
                           {1.0, 1.0},
                           parameter_name(name) + ": 95 % interval",
                           stage_colour(colour),
                           5.0);
      interval["showlegend"] = false;
      choice.traces.push_back(interval);
    }
    for (const double value : values) {
      lowest = std::fmin(lowest, value);
      highest = std::fmax(highest, value);
    }
  }
  if (has_limit) {
    Json limit = line({lowest, highest}, {1.0, 1.0}, "limit", "var(--ink)", 1.5);
    limit["line"]["dash"] = "dash";
    choice.traces.push_back(limit);
  }
  return {
      .id = "search-profile" + (unit.empty() ? "" : "-" + identifier(unit)),
      .caption =
          has_limit
              ? "Excess: how much worse the objective is than the best, for one parameter at a "
                "time. It is divided by what other replicates and seeds could explain. Where "
                "they explain nothing, it is divided by the most that they explain elsewhere, "
                "and 1 is added. Values below the dashed line cannot be told from the best. The "
                "thick part of that line is the 95 % interval: it ends at the nearest value that "
                "was "
                "shown to be worse, or where the search ended."
              : "Excess: how much worse the objective is than the best, for one parameter at a "
                "time. Other replicates and seeds explain none of these differences, so each "
                "interval ends at the nearest worse value that was tried.",
      .height = 400,
      .layout = {{"xaxis", axis(plot_text(value_axis(unit)))},
                 {"yaxis",
                  axis(has_limit ? "Excess / allowed excess" : "Excess of the objective")}},
      .menu = "",
      .choices = {choice}};
}

// One figure a unit.
void add_profiles(const Json& parameters, const datasets::Table& table, Section& section) {
  const auto names = text_column(table, "parameter");
  const auto values = column(table, "value");
  const auto excess = column(table, "excess");
  const auto allowed = column(table, "allowed_excess");
  // In units of what is allowed; where nothing is allowed anywhere, as it is. What is far off is
  // allowed nothing at all: above the limit, by its excess in units of the most that its parameter
  // was allowed. Where that is nothing, only the best itself has a place beside the others.
  std::map<std::string, double> most_allowed;
  for (std::size_t i = 0; i < names.size(); ++i)
    most_allowed[names[i]] = std::fmax(most_allowed[names[i]], allowed[i]);
  const bool has_limit = std::any_of(
      most_allowed.begin(), most_allowed.end(), [](const auto& most) { return most.second > 0.0; });
  std::vector<Profile> profiles;
  std::vector<std::string> units;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double most = most_allowed[names[i]];
    const double shown = excess[i] == 0.0 || !has_limit ? excess[i]
                         : allowed[i] > 0.0             ? excess[i] / allowed[i]
                         : most > 0.0                   ? 1.0 + excess[i] / most
                                                        : std::nan("");
    Profile& profile = with_key(profiles, &Profile::name, names[i]);
    profile.values.push_back(values[i]);
    profile.excesses.push_back(shown);
    add_once(units, parameter_unit(names[i]));
  }
  for (const std::string& unit : units)
    section.add_figure(profile_figure(parameters, profiles, unit, has_limit));
}

// What the form of the objective that was not searched by would have chosen.
void add_other_objective(const RunData& data, Section& section) {
  const Json& forms = list(data.result, {"objective", "by_form"});
  if (forms.size() < 2) return;
  std::vector<std::string> requested;
  if (at(data.result, {"agreement"}).is_object()) requested.emplace_back("one minus the agreement");
  if (!list(data.result, {"comparison"}).empty())
    requested.emplace_back(
        "the distance of Beverloo's C and k and of the kinematic B, in units of their uncertainty");
  section.add_paragraph(fmt::format(
      "The search minimised the {} objective. The smooth one is the distance from what was "
      "measured, in units of its uncertainty.{} The table shows the evaluation that each of the "
      "two prefers.",
      text(data.result, {"objective", "form"}),
      requested.empty() ? "" : fmt::format(" The requested one is {}.", joined(requested))));
  std::vector<TableView::Column> columns = {{"Form", Align::left}};
  const Json& parameters = at(forms[0], {"parameters"});
  for (const auto& [name, value] : parameters.items()) columns.push_back({parameter_axis(name)});
  columns.insert(columns.end(), {{"Smooth objective"}, {"Requested objective"}});
  TableView view("The best evaluation by either form of the objective", columns);
  for (const Json& best : forms) {
    std::vector<std::string> cells = {text(best, {"form"})};
    for (const auto& [name, value] : parameters.items())
      cells.push_back(significant(number(best, {"parameters", name})));
    for (const char* form : {"smooth", "requested"})
      cells.push_back(significant(number(best, {form})));
    view.add_row(cells);
  }
  section.add_table(view);
}

}  // namespace

Section search_section(const RunData& data, Section section) {
  const auto table = data.table("evaluations");
  if (!table) {
    section.add_absence(data.is_under_way() ? "No evaluation has ended yet."
                        : data.is_calibration()
                            ? "The record of evaluations (tables/evaluations.csv) is absent, so "
                              "the search cannot be shown."
                            : "Nothing was searched in this run: the parameters were given.");
  } else {
    const Evaluations all = read_evaluations(*table);
    const bool has_plane = !all.varied.empty();
    if (has_plane) section.add_figure(plane_figure(data, all));
    if (!data.is_under_way()) section.begin_fold("How the search went");
    const double noise = number(data.result, {"objective", "noise"});
    const double best = number(data.result, {"objective", "best"});
    if (std::isfinite(best)) {
      section.add_paragraph(fmt::format(
          "Fresh simulations at the parameters of this page have an objective of {}. {}",
          significant(best, 4),
          std::isfinite(noise)
              ? fmt::format("The seeds alone give it a standard error of {}, so "
                            "smaller differences in the figures mean nothing.",
                            significant(noise, 2))
              : std::string("How much it varies between seeds was not measured.")));
    }
    const double truths = number(data.result, {"self_test", "truths"});
    if (std::isfinite(truths)) {
      section.add_paragraph(fmt::format(
          "Self-test before the search: each of {} parameter sets took the place of the "
          "experiment, with half of its seeds. The other half of the seeds found {} of them again "
          "among all.",
          count(truths),
          count(number(data.result, {"self_test", "found"}))));
    }
    const std::string reason = text(data.result, {"objective", "stop_reason"});
    if (!reason.empty())
      section.add_paragraph(fmt::format("Why the local search ended: {}.", reason));
    add_other_objective(data, section);
    section.add_table(stage_table(all));
    section.add_figure(convergence_figure(all));
  }
  if (!data.is_calibration() || data.is_under_way()) return section;

  section.begin_fold("What the intervals rest on");
  if (const auto profile = data.table("profile")) {
    add_profiles(at(data.result, {"parameters"}), *profile, section);
  } else {
    section.add_absence(
        "There are no profiles (tables/profile.csv): no parameter has an interval, or the table is "
        "absent.");
  }
  return section;
}

}  // namespace graintruth::reports
