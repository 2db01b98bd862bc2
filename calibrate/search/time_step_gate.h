// The time step is no material constant: it is the largest at which the answer no longer changes.
// Found before the search, so that the search cannot use it as a free parameter.
#pragma once

#include "calibrate/ensemble.h"

namespace graintruth::calibrate {

// One fraction at one place of the parameter box.
struct TimeStepRow {
  ParameterSet parameters;
  double fraction = 0.0;   // of the Rayleigh step
  double time_step = 0.0;  // s
  double objective = 0.0;
  double change = 0.0;   // objective here minus that at half the step; NaN at the smallest
  double noise = 0.0;    // standard error of that change if both had seeds of their own
  double seconds = 0.0;  // processor time
  int failed = 0;        // runs that did not complete at this very step
};

struct TimeStepChoice {
  double fraction = 0.0;
  double time_step = 0.0;             // s
  double discretisation_error = 0.0;  // largest |change| at the chosen fraction
  bool converged = false;  // false: even the smallest fraction tried still changes the objective
  bool joint = false;      // searched with the parameters instead
  std::vector<TimeStepRow> rows;
};

// Evaluates `largest`, its half and its quarter at every place, and chooses the largest fraction at
// which no run failed and |change| <= 1.96 noise everywhere.
TimeStepChoice choose_time_step(Ensemble& ensemble,
                                std::span<const ParameterSet> places,
                                double largest,
                                std::span<const std::uint64_t> seeds,
                                const SimulationProgress& progress = {});

// How much halving the step may change the objective at a fraction between the largest and the
// smallest that were tried: the largest |change| of all places, linear in the fraction between
// those tried, and towards 0 below.
double discretisation_error_at(const TimeStepChoice& choice, double fraction);

}  // namespace graintruth::calibrate
