#include "calibrate/compare/step_change.h"

#include <cmath>

namespace graintruth::calibrate {

std::string_view name_of(StepVerdict verdict) {
  switch (verdict) {
    case StepVerdict::resolved:
      return "resolved";
    case StepVerdict::changes:
      return "changes";
    case StepVerdict::not_resolved:
      break;
  }
  return "not_resolved";
}

StepVerdict StepChange::verdict() const {
  // Not Student's t: where a few runs tell little, a smaller step is the safer one
  constexpr double confidence_95 = 1.96;
  if (std::abs(change) + noise.half_width <= allowed) return StepVerdict::resolved;
  return std::abs(change) > confidence_95 * noise.standard_error ? StepVerdict::changes
                                                                 : StepVerdict::not_resolved;
}

StepChange step_change(const Comparison& comparison,
                       const Evaluation& at,
                       const Evaluation& at_half) {
  constexpr double share = 0.5;  // of what other replicates could move the objective by
  return {at.objective - at_half.objective,
          comparison.noise_of_difference(at, at_half),
          share * comparison.half_width_by_replicates(at_half)};
}

}  // namespace graintruth::calibrate
