// How the values were found: the evaluations in their order and in the plane of the two frictions,
// what the interval rests on, and the root-mean-square distance at fixed frictions, as the thesis
// chose its own.
#include <fmt/format.h>

#include <algorithm>
#include <array>
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
                      axis("Objective (mean pseudo-Huber loss)",
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
  Json best = points({best_x}, {best_y}, "result", "rgba(0,0,0,0)", "star", 17.0);
  best["marker"]["line"] = {{"width", 2}, {"color", "var(--simulated)"}};
  choice.traces.push_back(best);
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

// Where only one friction is identified, its draws have one dimension.
Figure bootstrap_histogram(const datasets::Table& table, std::string_view name) {
  FigureChoice choice;
  choice.traces.push_back({{"type", "histogram"},
                           {"x", plot_numbers(column(table, name))},
                           {"name", "draws"},
                           {"marker", {{"color", "var(--measured-strong)"}}}});
  return {
      .id = "search-bootstrap",
      .caption =
          "Where the result would have been with other replicates drawn from these: the wider the "
          "heap, the "
          "less the films fix the parameter.",
      .height = 360,
      .layout = {{"xaxis", axis(parameter_name(name))}, {"yaxis", axis("Draws")}, {"bargap", 0.05}},
      .menu = "",
      .choices = {choice}};
}

Figure bootstrap_figure(const RunData& data, const datasets::Table& table) {
  // The columns are "draw" and what was identified.
  if (!table.has("friction_particle_particle") || !table.has("friction_particle_wall"))
    return bootstrap_histogram(table, table.columns().back());
  FigureChoice choice;
  choice.traces.push_back(points(column(table, "friction_particle_particle"),
                                 column(table, "friction_particle_wall"),
                                 "draw",
                                 "var(--measured-strong)",
                                 "circle",
                                 6.0));
  choice.traces.back()["marker"]["opacity"] = 0.45;
  const Json& particle = at(data.result, {"parameters", "friction_particle_particle"});
  const Json& wall = at(data.result, {"parameters", "friction_particle_wall"});
  const auto arm = [](double value, const char* side, const Json& parameter) {
    return std::abs(number(parameter, {side}) - value);
  };
  const double x = number(particle, {"value"});
  const double y = number(wall, {"value"});
  Json result = points({x}, {y}, "result and its intervals", "var(--simulated)", "circle", 9.0);
  const auto error_bar = [&](double value, const Json& parameter) {
    return Json{{"type", "data"},
                {"symmetric", false},
                {"array", plot_numbers({arm(value, "upper", parameter)})},
                {"arrayminus", plot_numbers({arm(value, "lower", parameter)})},
                {"thickness", 2}};
  };
  result["error_x"] = error_bar(x, particle);
  result["error_y"] = error_bar(y, wall);
  choice.traces.push_back(result);
  return {.id = "search-bootstrap",
          .caption =
              "Where the result would have been with other replicates drawn from these: a round "
              "cloud means two "
              "frictions that are known apart, a slanted one that they trade off.",
          .height = 420,
          .layout = {{"xaxis", axis("Friction, particle to particle")},
                     {"yaxis", axis("Friction, particle to wall")}},
          .menu = "",
          .choices = {choice}};
}

Figure profile_figure(const datasets::Table& table) {
  const auto names = text_column(table, "parameter");
  const auto values = column(table, "value");
  const auto objectives = column(table, "objective");
  const auto sigmas = column(table, "sigma");
  std::map<std::string, std::array<std::vector<double>, 3>> profiles;
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto& profile = profiles[names[i]];
    profile[0].push_back(values[i]);
    profile[1].push_back(objectives[i]);
    profile[2].push_back(sigmas[i]);
  }
  FigureChoice choice;
  std::size_t colour = 0;
  for (const auto& [name, profile] : profiles) {
    Json trace = points(profile[0], profile[1], parameter_name(name), stage_colour(++colour));
    trace["mode"] = "lines+markers";
    trace["error_y"] = {
        {"type", "data"}, {"array", plot_numbers(profile[2])}, {"thickness", 1.2}, {"width", 3}};
    choice.traces.push_back(trace);
  }
  return {
      .id = "search-profile",
      .caption =
          "The objective along one parameter at a time: the narrower the trough against its error "
          "bars, the "
          "better the films fix that parameter; a flat profile is one that they do not.",
      .height = 400,
      .layout = {{"xaxis", axis("Parameter value (dimensionless)")}, {"yaxis", axis("Objective")}},
      .menu = "",
      .choices = {choice}};
}

// Section 4.2.2 of the thesis: root-mean-square numbers of its own normalisation, mm.
struct ThesisRms {
  double friction;
  double printed_mm;
  int place;
};
constexpr ThesisRms thesis_rms[] = {{0.0, 1052, 4}, {0.1, 532, 1}, {0.2, 951, 3}, {0.35, 731, 2}};

const ThesisRms* thesis_value(double friction) {
  for (const ThesisRms& row : thesis_rms)
    if (std::abs(row.friction - friction) < 1e-9) return &row;
  return nullptr;
}

}  // namespace

Section search_section(const RunData& data) {
  Section section("search", "Search");
  const auto table = data.table("evaluations");
  if (!table) {
    section.add_absence(data.is_calibration()
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
    const std::string reason = text(data.result, {"objective", "stop_reason"});
    if (!reason.empty()) section.add_paragraph(fmt::format("Why the search ended: {}.", reason));
    section.add_table(stage_table(all));
    section.add_figure(convergence_figure(all));
    section.add_figure(plane_figure(data, all));
  }
  if (!data.is_calibration()) return section;

  section.add_heading("What the intervals rest on");
  const auto bootstrap = data.table("bootstrap");
  const auto profile = data.table("profile");
  const double error = number(data.result, {"objective", "surrogate_leave_one_out_error"});
  if (std::isfinite(error)) {
    section.add_paragraph(
        fmt::format("Each draw's minimum is that of a surrogate of the log objective. The "
                    "surrogate predicts an evaluation that it "
                    "has not seen to {}, where the evaluations themselves spread by {}.",
                    significant(error, 2),
                    significant(number(data.result, {"objective", "surrogate_value_spread"}), 2)));
  }
  const bool has_draws = bootstrap && bootstrap->columns().size() > 1;
  if (has_draws) section.add_figure(bootstrap_figure(data, *bootstrap));
  if (profile) section.add_figure(profile_figure(*profile));
  if (!has_draws && !profile) {
    section.add_absence(
        "Neither bootstrap draws (tables/bootstrap.csv) nor profiles (tables/profile.csv) were "
        "recorded in this run.");
  }
  return section;
}

Section rms_section(const RunData& data) {
  Section section("rms", "RMS distance against friction");
  const auto table = data.table("rms_friction");
  if (!table) {
    section.add_absence(
        "The distance at fixed frictions (tables/rms_friction.csv) was not computed in this run.");
    return section;
  }
  section.add_paragraph(
      "The thesis chose its friction this way: one value for particles and walls alike, four of "
      "them tried, the "
      "smallest root-mean-square distance kept. It printed 532 mm at 0.1, then 731 at 0.35, 951 at "
      "0.2 and 1052 at 0. "
      "Its sums are normalised otherwise than ours, so only the order can be compared.");
  const auto friction = column(*table, "friction");
  auto rms = column(*table, "rms_position_m");
  auto spread = column(*table, "spread_m");
  const auto agreement = column(*table, "agreement_percent");
  for (double& value : rms) value *= 1000.0;
  for (double& value : spread) value *= 1000.0;

  TableView view("RMS distance of the simulated from the filmed centres at fixed frictions",
                 {{"Friction", Align::left},
                  {"RMS distance (mm)"},
                  {"Spread over seeds (mm)"},
                  {"Agreement (Student)"},
                  {"Place here"},
                  {"Place in the thesis"},
                  {"Thesis, its own sum (mm)"}});
  for (std::size_t i = 0; i < friction.size(); ++i) {
    const auto better =
        std::count_if(rms.begin(), rms.end(), [&](double other) { return other < rms[i]; });
    const ThesisRms* printed = thesis_value(friction[i]);
    view.add_row({decimal(friction[i], 2),
                  decimal(rms[i], 1),
                  decimal(spread[i], 1),
                  percent(agreement[i]),
                  std::isfinite(rms[i]) ? std::to_string(better + 1) : std::string(nothing),
                  printed != nullptr ? std::to_string(printed->place) : std::string(nothing),
                  printed != nullptr ? decimal(printed->printed_mm, 0) : std::string(nothing)});
  }
  section.add_table(view);

  FigureChoice choice;
  Json ours = points(friction, rms, "this run", "var(--measured-strong)", "circle", 9.0);
  ours["mode"] = "lines+markers";
  ours["line"] = {{"color", "var(--measured-strong)"}, {"width", 1.5}};
  ours["error_y"] = {{"type", "data"}, {"array", plot_numbers(spread)}, {"thickness", 1.5}};
  choice.traces.push_back(ours);
  Json shapes = Json::array();
  Json notes = Json::array();
  for (const ThesisRms& row : thesis_rms) {
    shapes.push_back({{"type", "line"},
                      {"x0", row.friction},
                      {"x1", row.friction},
                      {"yref", "paper"},
                      {"y0", 0},
                      {"y1", 1},
                      {"layer", "below"},
                      {"line", {{"color", "var(--faint)"}, {"width", 1}, {"dash", "dot"}}}});
    notes.push_back({{"x", row.friction},
                     {"yref", "paper"},
                     {"y", 1.0},
                     {"yanchor", "bottom"},
                     {"showarrow", false},
                     {"text", fmt::format("thesis: {}", ordinal(row.place))}});
  }
  section.add_figure(
      {.id = "rms-friction",
       .caption =
           "RMS distance with its spread over seeds; the dotted lines mark the four frictions that "
           "the thesis tried and the places in which they came.",
       .height = 380,
       .layout = {{"xaxis", axis("Friction, the same for particles and walls")},
                  {"yaxis", axis("RMS distance (mm)", {{"rangemode", "tozero"}})},
                  {"shapes", shapes},
                  {"annotations", notes},
                  {"showlegend", false}},
       .menu = "",
       .choices = {choice}});
  return section;
}

}  // namespace graintruth::reports
