// The time step is no material constant: it is the largest at which the answer no longer changes.
// Found before the search, so that the search cannot use it as a free parameter.
#pragma once

#include "calibrate/compare/step_change.h"
#include "calibrate/ensemble.h"

namespace graintruth::calibrate {

// One fraction at one place of the parameter box.
struct TimeStepRow {
  ParameterSet parameters;
  double fraction = 0.0;   // of the Rayleigh step
  double time_step = 0.0;  // s
  double objective = 0.0;
  std::optional<StepChange> change;  // to half the step; none at the smallest
  double seconds = 0.0;              // processor time
  int seeds = 0;                     // with which it was simulated
  int failed = 0;                    // runs that did not complete at this very step
};

struct TimeStepChoice {
  double fraction = 0.0;
  double time_step = 0.0;                           // s
  double discretisation_error = 0.0;                // largest |change| of it that matters
  StepVerdict verdict = StepVerdict::not_resolved;  // of the worst place
  bool joint = false;                               // searched with the parameters instead
  std::vector<TimeStepRow> rows;
};

// Evaluates `largest` and its half at every place, with the first few of the seeds, and takes the
// step if the rule of step_change.h says that it is resolved at every place where the objective is
// not hopeless beside the others: what changes there changes no answer. Where runs scatter, more
// seeds are spent, if all of them can be enough. A step at which the change can be told from chance
// or runs fail makes way for its half; one at which nothing can be told stays and is said to be not
// resolved: a smaller one would cost more and tell no more. `progress` makes the report of each
// batch, whose simulations cost so many at the largest step.
TimeStepChoice choose_time_step(
    Ensemble& ensemble,
    std::span<const ParameterSet> places,
    double largest,
    std::span<const std::uint64_t> seeds,
    std::size_t first_seeds,
    const std::function<SimulationProgress(double cost)>& progress = {});

// How much halving the step may change the objective at a fraction between the largest and the
// smallest that were tried: the largest |change| of all places, linear in the fraction between
// those tried, and towards 0 below.
double discretisation_error_at(const TimeStepChoice& choice, double fraction);

}  // namespace graintruth::calibrate
