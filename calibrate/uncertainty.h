// How well the data pin the parameters down: the minimum of the objective is found again and again
// for replicates and seeds drawn anew from those at hand.
#pragma once

#include "calibrate/problem.h"
#include "calibrate/surrogate.h"

namespace graintruth::calibrate {

struct Interval {
  double lower = 0.0;
  double upper = 0.0;
};

struct BootstrapOptions {
  int draws = 400;
  std::uint64_t seed = 1;
  int jobs = 1;
};

struct Bootstrap {
  UnitPoint minimum;                 // of the surrogate, on all replicates
  std::vector<UnitPoint> draws;      // the minimum for each draw
  std::vector<Interval> interval;    // 95 %, in the unit cube, one a dimension; clipped to it
  double leave_one_out_error = 0.0;  // of the surrogate, in log objective
  double value_spread = 0.0;         // of the log objective over the evaluations
};

// Minimum of the log objective over the unit cube of `space`, with a bootstrap over replicates
// (outer) and seeds (inner) on stored simulations; no new ones are run. The distances of the
// percentiles from the minimum are stretched by t(0.975, n-1)/1.96 sqrt(n/(n-1)), because n
// replicates drawn from n vary too little (Efron and Tibshirani 1993, section 5.3; Hesterberg
// 2015).
Bootstrap bootstrap_minimum(const Problem& problem,
                            std::span<const Evaluation> evaluations,
                            const ParameterSpace& space,
                            const BootstrapOptions& options);

}  // namespace graintruth::calibrate
