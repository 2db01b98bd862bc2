// What is told of filmed outlines beside what is compared of them: one row a replicate.
#pragma once

#include "calibrate/observables/observable.h"
#include "calibrate/result/results.h"

namespace graintruth::calibrate {

// Table `outlines`: angles of both flanks with their standard errors, height and feet of the bed at
// rest; of a drum the slope of its mean surface. Once, however many observables ask for it.
void tell_outlines(const MeasuredExperiment& measured, Results& results);

}  // namespace graintruth::calibrate
