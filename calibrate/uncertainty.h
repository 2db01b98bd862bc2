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

// Objectives of the same evaluations for replicates (outer) and seeds (inner) drawn anew:
// [draw][evaluation]. No new simulations are run.
std::vector<std::vector<double>> draw_objectives(const Problem& problem,
                                                 std::span<const Evaluation> evaluations,
                                                 const BootstrapOptions& options);

// Because n replicates drawn from n vary too little, distances are stretched by t(0.975, n-1)/1.96
// sqrt(n/(n-1)) (Efron and Tibshirani 1993, section 5.3; Hesterberg 2015).
double small_sample_stretch(std::size_t replicates);

// The range of the objective over a few evaluations that replicates and seeds alone would give in
// 95 % of cases if all had the same expectation.
double range_of_noise(const Problem& problem,
                      std::span<const Evaluation> evaluations,
                      const BootstrapOptions& options);

struct Bootstrap {
  UnitPoint minimum;                 // of the surrogate, on all replicates
  std::vector<UnitPoint> draws;      // the minimum for each draw
  std::vector<Interval> interval;    // 95 %, in the unit cube, one a dimension; clipped to it
  double leave_one_out_error = 0.0;  // of the surrogate, in log objective
  double value_spread = 0.0;         // of the log objective over the evaluations
};

// Minimum of the log objective over the unit cube of `space`, and the same for every draw. The 95 %
// interval is that of the draws' percentiles, stretched for the small sample.
Bootstrap bootstrap_minimum(const Problem& problem,
                            std::span<const Evaluation> evaluations,
                            const ParameterSpace& space,
                            const BootstrapOptions& options);

}  // namespace graintruth::calibrate
