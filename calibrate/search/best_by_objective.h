// What each form of the objective would have chosen from one search's evaluations.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

struct BestByObjective {
  datasets::ObjectiveForm form = datasets::ObjectiveForm::smooth;
  ParameterSet parameters;  // of the evaluation with the lowest objective of this form
  // There; none where the replicates do not tell what the form needs
  std::optional<double> smooth, requested;
};

// One for each form that the replicates allow; nothing without evaluations.
std::vector<BestByObjective> best_by_each_objective(const Comparison& comparison,
                                                    std::span<const Evaluation> evaluations);

}  // namespace graintruth::calibrate
