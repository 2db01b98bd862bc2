#include "calibrate/search/best_by_objective.h"

#include <algorithm>
#include <array>

namespace graintruth::calibrate {

std::vector<BestByObjective> best_by_each_objective(const Comparison& comparison,
                                                    std::span<const Evaluation> evaluations) {
  using datasets::ObjectiveForm;
  if (evaluations.empty()) return {};
  const auto values_of = [&](ObjectiveForm form) {
    std::vector<double> values;
    if (form == comparison.form()) {
      for (const Evaluation& evaluation : evaluations) values.push_back(evaluation.objective);
    } else if (const auto other = comparison.with_form(form)) {
      for (const Evaluation& evaluation : evaluations)
        values.push_back(other->objective(evaluation.runs));
    }
    return values;
  };
  const std::vector<double> smooth = values_of(ObjectiveForm::smooth);
  const std::vector<double> requested = values_of(ObjectiveForm::requested);
  const auto at = [](const std::vector<double>& values, std::size_t i) {
    return values.empty() ? std::nullopt : std::optional(values[i]);
  };
  std::vector<BestByObjective> best;
  for (const auto& [form, values] : {std::pair(ObjectiveForm::smooth, &smooth),
                                     std::pair(ObjectiveForm::requested, &requested)}) {
    if (values->empty()) continue;
    const auto lowest = static_cast<std::size_t>(std::min_element(values->begin(), values->end()) -
                                                 values->begin());
    best.push_back(
        {form, evaluations[lowest].parameters, at(smooth, lowest), at(requested, lowest)});
  }
  return best;
}

}  // namespace graintruth::calibrate
