// Whether half the time step gives another answer: one rule for the step that is chosen before the
// search, and for its check at the parameters found.
//
//   |J(step) - J(step/2)| + w  <=  W/2
//
// w is the 95 % half width of that change that the seeds leave, W the 95 % half width of J at the
// same parameters that the replicates leave. So the step is *shown* to move J by no more than half
// of what other replicates could move it. Runs that scatter make w larger and never W.
#pragma once

#include <string_view>

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

enum class StepVerdict {
  resolved,      // as above
  changes,       // more than 1.96 standard errors, which may be more than is allowed
  not_resolved,  // runs scatter too much to tell
};
// As result.json calls it: "resolved", "changes", "not_resolved".
std::string_view name_of(StepVerdict verdict);

struct StepChange {
  double change = 0.0;   // objective at the step minus that at its half
  SeedNoise noise;       // of that; its half width is w
  double allowed = 0.0;  // W/2

  StepVerdict verdict() const;
};

// Both of the same seeds and parameters.
StepChange step_change(const Comparison& comparison,
                       const Evaluation& at,
                       const Evaluation& at_half);

}  // namespace graintruth::calibrate
