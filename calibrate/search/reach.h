// Whether what was measured lies within what the model can reach at all between the bounds: told
// after the design, before more is spent.
#pragma once

#include <span>
#include <vector>

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

// Share of the measured values, 0 to 1, that every evaluation misses on the same side by more than
// the replicates' interval. NaN where no evaluation completed.
double share_out_of_reach(const Comparison& comparison, std::span<const Evaluation> evaluations);

}  // namespace graintruth::calibrate
