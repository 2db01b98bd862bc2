// Several experiments calibrated together: what each adds to the objective, and its own result.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

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
  return fmt::format("flow rates {} too {} on average{}",
                     percent(100.0 * std::abs(error)),
                     error < 0.0 ? "low" : "high",
                     held_out > 0.0 ? fmt::format(", orifices held out: {}", count(held_out)) : "");
}

// One name, or a list of observables.
std::string compared_text(const Json& experiment) {
  std::vector<std::string> names;
  for (const Json& name : list(experiment, {"compared"})) names.push_back(spaced(text(name, {})));
  return names.empty() ? spaced(text(experiment, {"compared"})) : joined(names);
}

}  // namespace

std::vector<std::string> experiment_sentences(const RunData& data) {
  const Json& experiments = list(data.result, {"experiments"});
  if (experiments.empty()) return {};
  std::vector<std::string> sentences = {fmt::format(
      "One set of parameters was sought for {} experiments on the same grains and walls.",
      experiments.size())};
  for (const Json& experiment : experiments)
    sentences.push_back(
        fmt::format("Experiment {}: {}.", text(experiment, {"name"}), outcome_of(experiment)));
  return sentences;
}

Section experiments_section(const RunData& data, Section section) {
  const Json& experiments = list(data.result, {"experiments"});
  section.add_paragraph(
      "The search minimised the weighted sum of the experiments' own objectives. These parameters "
      "describe an experiment with a large share of that sum less well than the others. If its own "
      "page says so too, its grains or walls may differ from those of the others.");
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
                   {"Result", Align::left}});
  Json links = Json::array();
  for (const Json& experiment : experiments) {
    const std::string name = text(experiment, {"name"});
    const double share = number(experiment, {"weight"}) * number(experiment, {"objective"}) / sum;
    table.add_row({name,
                   compared_text(experiment),
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
