// What is told of a bed that runs out: discharge, rates with their errors, pauses and jams, curves,
// velocity profiles, what stands still, and the constants of the laws that these follow.
#pragma once

#include "calibrate/problem.h"
#include "calibrate/result/confirmation.h"
#include "calibrate/result/results.h"

namespace graintruth::calibrate {

// Discharge, steady rate, pauses, bed and velocity profile of each replicate; rate of each orifice
// with its interval from the scatter of replicates; Beverloo's C and k where there are at least
// three orifices; the kinematic B of each orifice.
void tell_flow(const MeasuredExperiment& measured, Results& results);

// The same of experiment and fresh simulations, and how far these are apart, in the terms of ASME
// V&V 20:
//   E = S - D,   u_val^2 = u_D^2 + u_S^2 + u_input^2 + u_num^2
void conclude_flow(const Problem& problem, const Confirmed& confirmed, Results& results);

// Rates through every orifice, of one evaluation.
void tell_rates(const Problem& problem, const Evaluation& evaluation, Results& results);

// A share of runs with its 95 % interval (Jeffreys: equal-tailed beta of k + 1/2, n - k + 1/2).
struct Probability {
  int happened = 0;
  int runs = 0;
  double lower = 0.0, upper = 0.0;
};
Probability probability_of(int happened, int runs);

}  // namespace graintruth::calibrate
