// How the values were found: the evaluations in their order and in the plane of the two frictions,
// and what the interval rests on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

struct Evaluations {
  std::vector<double> number, particle, wall, objective, best;
  std::vector<std::string> stage;
  std::vector<bool> failed;  // some of its simulations did not end well
  std::vector<double> failed_simulations;
  std::vector<std::string> stages;  // in order of appearance
};

Evaluations read_evaluations(const datasets::Table& table) {
  Evaluations all{.number = column(table, "evaluation"),
                  .particle = column(table, "friction_particle_particle"),
                  .wall = column(table, "friction_particle_wall"),
                  .objective = column(table, "objective"),
                  .best = column(table, "best"),
                  .stage = text_column(table, "stage"),
                  .failed = {},
                  .failed_simulations = column(table, "failed"),
                  .stages = {}};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    all.failed.push_back(all.failed_simulations[i] > 0.0 || !std::isfinite(all.objective[i]));
    if (std::find(all.stages.begin(), all.stages.end(), all.stage[i]) == all.stages.end())
      all.stages.push_back(all.stage[i]);
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
              "The objective at every evaluation, and the best so far: a line that is flat long "
              "before the end "
              "says that more budget would have found no more.",
          .height = 400,
          .layout = {{"xaxis", axis("Evaluation")},
                     {"yaxis",
                      axis("Objective",
                           {{"type", "log"}, {"tickvals", ticks}, {"ticktext", tick_texts}})}},
          .menu = "",
          .choices = {choice}};
}

Figure plane_figure(const RunData& data, const Evaluations& all) {
  std::vector<double> x, y, objective, failed_x, failed_y;
  Json hover = Json::array();
  for (std::size_t i = 0; i < all.objective.size(); ++i) {
    if (all.failed[i]) {
      failed_x.push_back(all.particle[i]);
      failed_y.push_back(all.wall[i]);
    }
    if (!std::isfinite(all.objective[i])) continue;
    x.push_back(all.particle[i]);
    y.push_back(all.wall[i]);
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
  const double best_x = number(data.result, {"parameters", "friction_particle_particle", "value"});
  const double best_y = number(data.result, {"parameters", "friction_particle_wall", "value"});
  if (std::isfinite(best_x) && std::isfinite(best_y)) {
    Json best = points({best_x}, {best_y}, "result", "rgba(0,0,0,0)", "star", 17.0);
    best["marker"]["line"] = {{"width", 2}, {"color", "var(--simulated)"}};
    choice.traces.push_back(best);
  }
  return {.id = "search-plane",
          .caption =
              "Every evaluation in the plane of the two frictions, dark where the objective is low "
              "(the scale "
              "ends at its upper quartile): a long dark valley means that the two trade off "
              "against each other.",
          .height = 480,
          .layout = {{"xaxis", axis("Friction, particle to particle")},
                     {"yaxis", axis("Friction, particle to wall")}},
          .menu = "",
          .choices = {choice}};
}

Figure profile_figure(const datasets::Table& table) {
  struct Profile {
    std::vector<double> values;
    std::vector<double> excesses;
  };
  const auto names = text_column(table, "parameter");
  const auto values = column(table, "value");
  const auto excess = column(table, "excess");
  const auto allowed = column(table, "allowed_excess");
  // In units of what is allowed; where nothing is allowed anywhere, as it is.
  const bool has_limit =
      std::any_of(allowed.begin(), allowed.end(), [](double a) { return a > 0.0; });
  // What is far off is allowed nothing at all: above the limit, by its excess in units of the most
  // that its parameter was allowed.
  std::map<std::string, double> most_allowed;
  for (std::size_t i = 0; i < names.size(); ++i)
    most_allowed[names[i]] = std::fmax(most_allowed[names[i]], allowed[i]);
  std::map<std::string, Profile> profiles;
  double lowest = values.empty() ? 0.0 : values.front();
  double highest = lowest;
  for (std::size_t i = 0; i < names.size(); ++i) {
    profiles[names[i]].values.push_back(values[i]);
    // Where nothing is allowed only the best itself has a place beside the others.
    const double most = most_allowed[names[i]];
    profiles[names[i]].excesses.push_back(excess[i] == 0.0 || !has_limit ? excess[i]
                                          : allowed[i] > 0.0             ? excess[i] / allowed[i]
                                          : most > 0.0                   ? 1.0 + excess[i] / most
                                                                         : std::nan(""));
    lowest = std::fmin(lowest, values[i]);
    highest = std::fmax(highest, values[i]);
  }
  FigureChoice choice;
  std::size_t colour = 0;
  for (const auto& [name, profile] : profiles) {
    Json trace =
        points(profile.values, profile.excesses, parameter_name(name), stage_colour(++colour));
    trace["mode"] = "lines+markers";
    choice.traces.push_back(trace);
  }
  if (has_limit) {
    Json limit = line({lowest, highest}, {1.0, 1.0}, "limit", "var(--ink)", 1.5);
    limit["line"]["dash"] = "dash";
    choice.traces.push_back(limit);
  }
  return {.id = "search-profile",
          .caption =
              has_limit
                  ? "How much worse the objective is than the best, one parameter at a time, in "
                    "units of what other replicates and seeds could explain (1 more where that is "
                    "nothing). Values below the dashed line cannot be told apart from the best: "
                    "they are the 95 % interval."
                  : "How much worse the objective is than the best, one parameter at a time. Other "
                    "replicates and seeds explain none of these differences, so each interval ends "
                    "at the nearest worse value that was tried.",
          .height = 400,
          .layout = {{"xaxis", axis("Parameter value (dimensionless)")},
                     {"yaxis",
                      axis(has_limit ? "Excess of the objective / allowed excess"
                                     : "Excess of the objective")}},
          .menu = "",
          .choices = {choice}};
}

// What the form of the objective that was not searched by would have chosen.
void add_other_objective(const RunData& data, Section& section) {
  const Json& forms = at(data.result, {"objective", "by_form"});
  if (!forms.is_array() || forms.size() < 2) return;
  section.add_paragraph(fmt::format(
      "The search went by the {} objective. The smooth one is the distance from what was measured "
      "in units of its uncertainty; the requested one is {}. Of the evaluations that were made, "
      "either form prefers:",
      text(data.result, {"objective", "form"}),
      data.is_flow()
          ? "the distance of Beverloo's C and k and of the kinematic B in units of theirs"
          : "one minus the agreement"));
  TableView view("The best evaluation by either form of the objective",
                 {{"Form", Align::left},
                  {"Friction between particles"},
                  {"Friction with the wall"},
                  {"Restitution"},
                  {"Smooth objective"},
                  {"Requested objective"}});
  for (const Json& best : forms) {
    const auto parameter = [&](const char* name) {
      return decimal(number(best, {"parameters", name}), 3);
    };
    view.add_row({text(best, {"form"}),
                  parameter("friction_particle_particle"),
                  parameter("friction_particle_wall"),
                  parameter("restitution"),
                  significant(number(best, {"smooth"}), 3),
                  significant(number(best, {"requested"}), 3)});
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
    const double noise = number(data.result, {"objective", "noise"});
    const double best = number(data.result, {"objective", "best"});
    if (std::isfinite(best)) {
      section.add_paragraph(fmt::format(
          "The lowest objective is {}. {}",
          significant(best, 4),
          std::isfinite(noise) ? fmt::format("Its standard error between lists of seeds is {}: "
                                             "smaller differences in the figures mean "
                                             "nothing.",
                                             significant(noise, 2))
                               : std::string("How far it varies between seeds was not measured.")));
    }
    const double truths = number(data.result, {"self_test", "truths"});
    if (std::isfinite(truths)) {
      section.add_paragraph(fmt::format(
          "Self-test before the search: each of {} parameter sets stood in for the experiment with "
          "half of its seeds; {} of them were found again among all by the other half.",
          count(truths),
          count(number(data.result, {"self_test", "found"}))));
    }
    const std::string reason = text(data.result, {"objective", "stop_reason"});
    if (!reason.empty()) section.add_paragraph(fmt::format("Why the search ended: {}.", reason));
    add_other_objective(data, section);
    section.add_table(stage_table(all));
    section.add_figure(convergence_figure(all));
    section.add_figure(plane_figure(data, all));
  }
  if (!data.is_calibration() || data.is_under_way()) return section;

  section.add_heading("What the intervals rest on");
  const auto profile = data.table("profile");
  if (profile) {
    section.add_figure(profile_figure(*profile));
  } else {
    section.add_absence("No profiles (tables/profile.csv) were recorded in this run.");
  }
  return section;
}

}  // namespace graintruth::reports
