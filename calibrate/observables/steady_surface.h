// The surface of a bed that flows steadily: its mean in time, once it has stopped drifting.
#pragma once

#include "calibrate/observables/bed_profile.h"

namespace graintruth::calibrate {

struct SteadySurface {
  std::size_t first = 0;            // moment of the outline from which on it is steady
  std::size_t moments = 0;          // from there on
  std::vector<double> x, mean, sd;  // m, of columns; NaN where it is not seen most of the time
  double slope = 0.0;               // rad above the level, rising to the right: the mean of a line
                                    // through the middle half of the width at every moment
  double slope_error = 0.0;         // rad, standard error
  double slope_sd = 0.0;            // rad, in time
  double correlation_time = 0.0;    // s, over which the slope forgets itself
  double independent = 0.0;         // moments that tell independently of each other
  bool is_drifting = false;         // to the end
};

// Nothing where the outline has fewer than 20 moments in which the middle is seen.
//
// From where on it is steady is found by the marginal standard error (White 1997): leaving out the
// first d moments makes the mean of the others the best known; more than half are never left out.
// It still drifts where that would leave out half, and the means of the first and the second half
// of the others differ by more than three standard errors. The correlation time is
//   tau = dt (1 + 2 sum rho_k)   until rho_k first falls below 0
// and the standard error sd sqrt(tau / T).
std::optional<SteadySurface> steady_surface(const datasets::Outline& outline,
                                            const Situation& situation);

}  // namespace graintruth::calibrate
