// The time step: what the objective does when it is halved, and what that costs.
#include <fmt/format.h>

#include <cmath>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

Section time_step_section(const RunData& data) {
  Section section("time-step", "Time step");
  const Json& time_step = at(data.result, {"time_step"});
  if (!time_step.is_object()) {
    section.add_absence("This run recorded no time step.");
    return section;
  }
  const double fraction = number(time_step, {"fraction"});
  const double error = number(time_step, {"discretisation_error"});
  section.add_paragraph(fmt::format(
      "The time step is {} s, {} of the largest stable one. It was settled before the search and not tuned with the "
      "frictions, because a coarse step acts like damping and could then be traded against them.{}",
      significant(number(time_step, {"seconds"})),
      plain(fraction),
      std::isfinite(error)
          ? fmt::format(" Halving it changes the objective by {}.", significant(error, 2))
          : ""));
  const Json& study = list(time_step, {"study"});
  if (study.empty()) {
    section.add_absence("No study of smaller time steps was made in this run.");
    return section;
  }

  TableView table("The objective at smaller time steps",
                  {{"Fraction of the stable step", Align::left},
                   {"Time step (s)"},
                   {"Objective"},
                   {"Change from the row above"},
                   {"Noise"},
                   {"Processor time"}});
  std::vector<double> fractions, objectives, noises, costs;
  for (const Json& row : study) {
    fractions.push_back(number(row, {"fraction"}));
    objectives.push_back(number(row, {"objective"}));
    noises.push_back(number(row, {"noise"}));
    costs.push_back(number(row, {"cpu_seconds"}));
    table.add_row({plain(fractions.back()),
                   significant(number(row, {"seconds"})),
                   significant(objectives.back(), 4),
                   significant(number(row, {"change"}), 2),
                   significant(noises.back(), 2),
                   seconds(costs.back())});
  }
  section.add_table(table);

  FigureChoice choice;
  std::vector<double> lower, upper;
  for (std::size_t i = 0; i < objectives.size(); ++i) {
    lower.push_back(objectives[i] - noises[i]);
    upper.push_back(objectives[i] + noises[i]);
  }
  Json objective = line(fractions, objectives, "objective", "var(--measured-strong)");
  objective["mode"] = "lines+markers";
  Json cost = line(fractions, costs, "processor time", "var(--simulated)");
  cost["mode"] = "lines+markers";
  place(cost, "x", "y2");
  choice.traces.push_back(band(fractions, lower, upper, "± noise between seeds", "var(--measured-band)"));
  choice.traces.push_back(objective);
  choice.traces.push_back(cost);
  section.add_figure(
      {.id = "time-step-study",
       .caption = "Objective (above) and processor time (below) against the time step: as long as the line stays inside "
                  "the shaded noise, a smaller step would buy nothing but cost.",
       .height = 440,
       .layout = {{"xaxis",
                   axis("Time step, fraction of the largest stable one",
                        {{"type", "log"},
                         {"tickvals", plot_numbers(fractions)},
                         {"ticktext", plot_numbers(fractions)},
                         {"anchor", "y2"}})},
                  {"yaxis", axis("Objective", {{"domain", {0.42, 1.0}}})},
                  {"yaxis2",
                   axis("Processor time (s)", {{"domain", {0.0, 0.34}}, {"rangemode", "tozero"}})}},
       .menu = "",
       .choices = {choice}});
  return section;
}

}  // namespace graintruth::reports
