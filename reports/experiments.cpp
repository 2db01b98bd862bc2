// Several experiments calibrated together: what each adds to the sum, and how it comes out.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

// "agreement 87.2 % (a perfect model: 91.4 %)" or "flow rates 1.3 % too low on average".
std::string outcome_of(const Json& experiment) {
  const double student = number(experiment, {"agreement_percent_student_t"});
  if (std::isfinite(student)) {
    return fmt::format("agreement {} (a perfect model: {})",
                       percent(student),
                       percent(number(experiment, {"ceiling_percent_student_t"})));
  }
  const double error = number(experiment, {"mean_signed_error"});
  if (!std::isfinite(error)) return std::string(nothing);
  const double held_out = number(experiment, {"held_out_orifices"});
  return fmt::format(
      "flow rates {} too {} on average{}",
      percent(100.0 * std::abs(error)),
      error < 0.0 ? "low" : "high",
      held_out > 0.0 ? fmt::format(", {} orifice(s) held out", count(held_out)) : "");
}

}  // namespace

std::vector<std::string> experiment_sentences(const RunData& data) {
  std::vector<std::string> sentences;
  std::vector<std::string> outcomes;
  for (const Json& experiment : list(data.result, {"experiments"}))
    outcomes.push_back(fmt::format("{}: {}", text(experiment, {"name"}), outcome_of(experiment)));
  if (outcomes.empty()) return sentences;
  sentences.push_back(
      fmt::format("One set of parameters was sought for {} experiments on the same grains and "
                  "walls; at these values they come out so. {}.",
                  outcomes.size(),
                  fmt::join(outcomes, "; ")));
  return sentences;
}

Section experiments_section(const RunData& data, Section section) {
  const Json& experiments = list(data.result, {"experiments"});
  if (experiments.empty()) {
    section.add_absence("result.json does not name the experiments of this calibration.");
    return section;
  }
  section.add_paragraph(
      "What was minimised is the weighted sum of the experiments' own objectives. An experiment "
      "with a large share of that sum is one that these parameters do not describe as well as the "
      "others: if its own page says so too, the grains or walls may not be the same.");
  double sum = 0.0;
  for (const Json& experiment : experiments)
    sum += number(experiment, {"weight"}) * number(experiment, {"objective"});
  TableView table("The experiments at the parameters found, simulated with fresh seeds",
                  {{"Experiment", Align::left},
                   {"Compared", Align::left},
                   {"Replicates"},
                   {"Weight"},
                   {"Objective"},
                   {"Share of the sum"},
                   {"How it comes out", Align::left}});
  Json links = Json::array();
  for (const Json& experiment : experiments) {
    const std::string name = text(experiment, {"name"});
    const double share = number(experiment, {"weight"}) * number(experiment, {"objective"}) / sum;
    table.add_row({name,
                   text(experiment, {"compared"}),
                   count(number(experiment, {"replicates"})),
                   plain(number(experiment, {"weight"})),
                   significant(number(experiment, {"objective"})),
                   percent(100.0 * share),
                   outcome_of(experiment)});
    links.push_back({{"link_name", name}, {"link_title", text(experiment, {"title"})}});
  }
  section.add_table(table);
  section.add_template("experiment_links", {{"links", links}});
  return section;
}

}  // namespace graintruth::reports
