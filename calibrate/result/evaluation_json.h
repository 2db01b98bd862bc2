// What `evaluate` prints of one evaluation of the scenes that are calibrated on. For .cpp files.
#pragma once

#include "calibrate/problem.h"
#include "calibrate/result/results.h"

namespace graintruth::calibrate {

// Shares of the objective by kind, what each observable tells of it, and the warnings that the
// verdict heeds; nothing of these where there are none.
void add_evaluation(const Problem& problem,
                    const Evaluation& evaluation,
                    std::span<const datasets::Warning> warnings,
                    Json& json);

}  // namespace graintruth::calibrate
