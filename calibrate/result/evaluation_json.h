// What `evaluate` prints of one evaluation of the scenes that are calibrated on. For .cpp files.
#pragma once

#include "calibrate/problem.h"
#include "calibrate/result/results.h"

namespace graintruth::calibrate {

// Shares of the objective by kind, and what each observable tells of it.
void add_evaluation(const Problem& problem, const Evaluation& evaluation, Json& json);

}  // namespace graintruth::calibrate
