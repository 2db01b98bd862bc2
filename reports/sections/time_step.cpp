// The time step: what the objective does when it is halved, and what that costs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// Whatever a row of the study has beside these is a parameter.
std::vector<std::string> parameters_of(const Json& row) {
  constexpr std::string_view others[] = {"fraction",
                                         "seconds",
                                         "objective",
                                         "change",
                                         "noise",
                                         "half_width",
                                         "allowed",
                                         "seeds",
                                         "cpu_seconds"};
  std::vector<std::string> names;
  for (const auto& [name, value] : row.items()) {
    if (std::find(std::begin(others), std::end(others), name) == std::end(others))
      names.push_back(name);
  }
  return names;
}

// 95 % half width of what halving changes. Older runs have its standard error, as if both
// steps had seeds of their own.
double half_width_of(const Json& row) {
  constexpr double confidence_95 = 1.96;
  const double half_width = number(row, {"half_width"});
  return std::isfinite(half_width) ? half_width : confidence_95 * number(row, {"noise"});
}

// The fractions tried at one place of the parameter range.
struct Study {
  std::string place;  // the parameters' values
  std::vector<Json> rows;

  std::vector<double> column(std::string_view name) const {
    std::vector<double> values;
    for (const Json& row : rows) values.push_back(number(row, {name}));
    return values;
  }
};

std::vector<Study> studies_of(const Json& rows) {
  std::vector<Study> studies;
  for (const Json& row : rows) {
    std::string place;
    for (const std::string& name : parameters_of(rows[0])) place += text(row, {name}) + " ";
    with_key(studies, &Study::place, place).rows.push_back(row);
  }
  return studies;
}

TableView study_table(const std::vector<Study>& studies) {
  const std::vector<std::string> parameters = parameters_of(studies[0].rows[0]);
  std::vector<TableView::Column> columns = {{"Place", Align::left}};
  for (const std::string& name : parameters) columns.push_back({parameter_axis(name)});
  columns.insert(columns.end(),
                 {{"Fraction of the stable step"},
                  {"Time step (s)"},
                  {"Objective"},
                  {"Change on halving"},
                  {"Give or take (95 %)"},
                  {"Allowed"},
                  {"Seeds"},
                  {"Processor time"}});
  TableView table("The objective at smaller time steps", columns);
  int place = 0;
  for (const Study& study : studies) {
    ++place;
    for (const Json& row : study.rows) {
      std::vector<std::string> cells = {std::to_string(place)};
      for (const std::string& name : parameters) cells.push_back(plain(number(row, {name})));
      cells.insert(cells.end(),
                   {plain(number(row, {"fraction"})),
                    significant(number(row, {"seconds"})),
                    significant(number(row, {"objective"}), 4),
                    significant(number(row, {"change"}), 2),
                    significant(half_width_of(row), 2),
                    significant(number(row, {"allowed"}), 2),
                    plain(number(row, {"seeds"})),
                    seconds(number(row, {"cpu_seconds"}))});
      table.add_row(cells);
    }
  }
  return table;
}

// Objectives are drawn from that at the smallest step: places differ by far more than steps do.
Figure study_figure(const std::vector<Study>& studies) {
  FigureChoice choice;
  int place_number = 0;
  for (const Study& study : studies) {
    const std::string label = fmt::format("place {}", ++place_number);
    const std::string shade = fmt::format("var(--stage{})", place_number % 6);
    const std::vector<double> fraction = study.column("fraction");
    const auto smallest = std::min_element(fraction.begin(), fraction.end()) - fraction.begin();
    std::vector<double> difference = study.column("objective"), bar;
    const double least = difference[static_cast<std::size_t>(smallest)];
    for (double& value : difference) value -= least;
    for (const Json& row : study.rows) bar.push_back(half_width_of(row));
    Json objective = line(fraction, difference, label, shade);
    objective["mode"] = "lines+markers";
    objective["error_y"] = {{"type", "data"}, {"array", plot_numbers(bar)}, {"thickness", 1.5}};
    Json cost = line(fraction, study.column("cpu_seconds"), label, shade);
    cost["mode"] = "lines+markers";
    cost["showlegend"] = false;
    place(cost, "x", "y2");
    choice.traces.push_back(objective);
    choice.traces.push_back(cost);
  }
  const Json ticks = plot_numbers(studies.front().column("fraction"));
  Json tick_texts = Json::array();
  for (const double fraction : studies.front().column("fraction"))
    tick_texts.push_back(plain(fraction));
  return {
      .id = "time-step-study",
      .caption =
          "Above: the objective less that at the smallest step. Below: the processor time. Bars "
          "are the 95 % interval of the change on halving. Where the left neighbour of a point "
          "lies "
          "within its bar, a smaller step changes nothing that can be told from noise.",
      .height = 460,
      .layout = {{"xaxis",
                  axis("Time step, fraction of the largest stable one",
                       {{"type", "log"},
                        {"tickvals", ticks},
                        {"ticktext", tick_texts},
                        {"anchor", "y2"}})},
                 {"yaxis", axis("Objective, difference", {{"domain", {0.42, 1.0}}})},
                 {"yaxis2",
                  axis("Processor time (s)", {{"domain", {0.0, 0.34}}, {"rangemode", "tozero"}})},
                 {"showlegend", studies.size() > 1}},
      .menu = "",
      .choices = {choice}};
}

}  // namespace

Section time_step_section(const RunData& data, Section section) {
  const Json& time_step = at(data.result, {"time_step"});
  if (!time_step.is_object()) {
    section.add_absence("This run recorded no time step.");
    return section;
  }
  const double error = number(time_step, {"discretisation_error"});
  section.add_paragraph(fmt::format(
      "The time step is {} s, {} of the largest stable (Rayleigh) one.{}",
      significant(number(time_step, {"seconds"})),
      plain(number(time_step, {"fraction"})),
      std::isfinite(error)
          ? fmt::format(" Halving it changes the objective by at most {}.", significant(error, 2))
          : ""));
  const Json& rows = list(time_step, {"study"});
  if (rows.empty()) {
    section.add_absence("No study of smaller time steps was made in this run.");
    return section;
  }
  if (text(time_step, {"rule"}) == "joint") {
    section.add_warnings(
        {"The time step was searched together with the parameters. A coarse step acts like "
         "damping, so step and parameters can make up for each other. These parameters hold at "
         "this time step only."});
  }
  if (text(time_step, {"verdict"}) == "not_resolved") {
    section.add_warnings(
        {"The time step is not resolved: runs scatter so much that nobody can tell whether a "
         "smaller "
         "step changes the results. Compare what scatters less from run to run, or check the "
         "results at half the time step."});
  } else if (at(time_step, {"converged"}) == false) {
    section.add_warnings(
        {"The objective still changes by more than noise between the two smallest time steps: the "
         "results depend on the time step."});
  }
  section.begin_fold("How the time step was chosen");
  if (text(time_step, {"rule"}) != "joint") {
    section.add_paragraph(
        "The time step was chosen before the search. It was not tuned with the parameters: a "
        "coarse step acts like damping, and the search could use it in place of a parameter. "
        "Halving it may change the objective by no more than half of what other replicates could "
        "change (allowed), and that must be shown: the change with its 95 % interval must fit in. "
        "Where runs scatter, more seeds are spent.");
  }
  const double change = number(time_step, {"at_half", "objective_change"});
  const double points = number(time_step, {"at_half", "agreement_change_points"});
  if (std::isfinite(change)) {
    section.add_paragraph(fmt::format(
        "At the parameters found, half the step changes the objective by {} (give or take {}; "
        "allowed {}){}.",
        significant(change, 2),
        significant(half_width_of(at(time_step, {"at_half"})), 2),
        significant(number(time_step, {"at_half", "allowed"}), 2),
        std::isfinite(points) ? fmt::format(" and the agreement by {} points", decimal(points, 1))
                              : ""));
  }
  const std::vector<Study> studies = studies_of(rows);
  section.add_table(study_table(studies));
  section.add_figure(study_figure(studies));
  return section;
}

}  // namespace graintruth::reports
