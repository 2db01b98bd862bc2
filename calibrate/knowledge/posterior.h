// What the surrogate makes of the whole landscape: parameter sets drawn as often as they are
// plausible. For correlations and maps; reported intervals are verified by real simulations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibrate/knowledge/uncertainty.h"
#include "calibrate/search/surrogate.h"

namespace graintruth::calibrate {

struct Posterior {
  std::vector<UnitPoint> draws;
  double effective_size =
      0.0;  // independent draws that they are worth; the least of all dimensions
};

// Random-walk Metropolis with a proposal that learns its covariance while it burns in (Haario,
// Saksman and Tamminen 2001), from `start`. The density is flat over the unit cube times
//   exp(-1.92 (J - J_min) / allowed),   J = exp(predicted mean) but for a constant:
// the mapping of prior.h, with what a profile allows at 95 %. What is allowed holds replicates,
// seeds and the roughness of the model, so that the latter is the discrepancy term. Where the
// surrogate's J holds a prior's penalty, the density holds that prior.
Posterior draw_posterior(const Surrogate& surrogate,
                         const UnitPoint& start,
                         double allowed,
                         std::uint64_t seed);

// One parameter over the posterior's draws.
struct PosteriorMarginal {
  std::string name;
  double mean = 0.0;
  double standard_deviation = 0.0;
  Interval credible;  // 95 %, equal tails
};

PosteriorMarginal marginal_of(const Posterior& posterior,
                              const ParameterSpace& space,
                              std::size_t dimension);

// The mean of all draws.
UnitPoint mean_of(const Posterior& posterior);

// n / (1 + 2 sum of autocorrelations), summed in pairs as long as they are positive (Geyer 1992).
double effective_sample_size(const std::vector<double>& chain);

}  // namespace graintruth::calibrate
