// The time step: what the objective does when it is halved, and what that costs.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

// The fractions tried at one place of the parameter range.
struct Study {
  std::vector<double> fraction, objective, noise, seconds;
};

std::string place_of(const Json& row) {
  const double particle = number(row, {"friction_particle_particle"});
  const double wall = number(row, {"friction_particle_wall"});
  if (!std::isfinite(particle) && !std::isfinite(wall)) return "the same parameters throughout";
  return fmt::format("frictions {} and {}", plain(particle), plain(wall));
}

TableView study_table(const Json& rows) {
  TableView table("The objective at smaller time steps",
                  {{"At", Align::left},
                   {"Fraction of the stable step"},
                   {"Time step (s)"},
                   {"Objective"},
                   {"Change on halving"},
                   {"Standard error of the change"},
                   {"Processor time"}});
  for (const Json& row : rows) {
    table.add_row({place_of(row),
                   plain(number(row, {"fraction"})),
                   significant(number(row, {"seconds"})),
                   significant(number(row, {"objective"}), 4),
                   significant(number(row, {"change"}), 2),
                   significant(number(row, {"noise"}), 2),
                   seconds(number(row, {"cpu_seconds"}))});
  }
  return table;
}

std::map<std::string, Study> studies_of(const Json& rows) {
  std::map<std::string, Study> studies;
  for (const Json& row : rows) {
    Study& study = studies[place_of(row)];
    study.fraction.push_back(number(row, {"fraction"}));
    study.objective.push_back(number(row, {"objective"}));
    study.noise.push_back(number(row, {"noise"}));
    study.seconds.push_back(number(row, {"cpu_seconds"}));
  }
  return studies;
}

// Objectives are drawn from that at the smallest step: places differ by far more than steps do.
Figure study_figure(const std::map<std::string, Study>& studies) {
  constexpr double confidence_95 = 1.96;
  FigureChoice choice;
  std::size_t colour = 0;
  for (const auto& [place_name, study] : studies) {
    std::size_t smallest = 0;
    for (std::size_t i = 0; i < study.fraction.size(); ++i)
      if (study.fraction[i] < study.fraction[smallest]) smallest = i;
    std::vector<double> difference, bar;
    for (std::size_t i = 0; i < study.objective.size(); ++i) {
      difference.push_back(study.objective[i] - study.objective[smallest]);
      bar.push_back(confidence_95 * study.noise[i]);
    }
    const std::string shade = fmt::format("var(--stage{})", ++colour % 6);
    Json objective = line(study.fraction, difference, place_name, shade);
    objective["mode"] = "lines+markers";
    objective["error_y"] = {{"type", "data"}, {"array", plot_numbers(bar)}, {"thickness", 1.5}};
    Json cost = line(study.fraction, study.seconds, place_name, shade);
    cost["mode"] = "lines+markers";
    cost["showlegend"] = false;
    place(cost, "x", "y2");
    choice.traces.push_back(objective);
    choice.traces.push_back(cost);
  }
  const Json ticks = plot_numbers(studies.begin()->second.fraction);
  return {
      .id = "time-step-study",
      .caption =
          "Objective, from that at the smallest step (above), and processor time (below). Bars are "
          "1.96 "
          "standard errors of the change on halving: as long as a point's left neighbour lies "
          "within its bar, "
          "a smaller step would buy nothing but cost.",
      .height = 460,
      .layout =
          {{"xaxis",
            axis("Time step, fraction of the largest stable one",
                 {{"type", "log"}, {"tickvals", ticks}, {"ticktext", ticks}, {"anchor", "y2"}})},
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
        {"It was searched together with the parameters. A coarse step acts like damping, so that "
         "either may make up for the other: these parameters hold at this time step only."});
  } else {
    section.add_paragraph(
        "It was settled before the search and not tuned with the frictions, because a coarse step "
        "acts like damping and "
        "could then be traded against them. Chosen is the largest at which halving changes nothing "
        "that can be told from "
        "noise.");
  }
  const double change = number(time_step, {"at_half", "objective_change"});
  if (std::isfinite(change)) {
    section.add_paragraph(fmt::format(
        "At the parameters found, half the step changes the objective by {} (noise of that: {}) "
        "and the agreement by {} points.",
        significant(change, 2),
        significant(number(time_step, {"at_half", "noise"}), 2),
        decimal(number(time_step, {"at_half", "agreement_change_points"}), 1)));
  }
  if (at(time_step, {"converged"}) == false) {
    section.add_warnings(
        {"Even the smallest time step tried still changes the objective by more than noise: the "
         "results depend on the "
         "time step."});
  }
  section.add_table(study_table(rows));
  section.add_figure(study_figure(studies_of(rows)));
  return section;
}

}  // namespace graintruth::reports
