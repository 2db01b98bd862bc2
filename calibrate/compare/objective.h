// The loss of one residual, z = (simulated mean - replicate mean) / half width: what the optimiser
// minimises is the mean of it over all that is compared (compare/channel_comparison.h).
//
//   smooth      rho(z) = sqrt(1 + (z/2)^2) - 1
//   requested   rho(z) = 1 where |z| > 1, else 0: the mean is one minus the agreement
//   (eqs 4.2, 4.3)
//
// The smooth rho grows linearly far out, so that one particle that goes astray does not rule the
// fit (Huber 1964). The requested one is as rough as it is plain: it does not tell near from far.
//
// Half widths of values that replicates repeat (compare/repeated_rule.h) are those of eq 4.2 with
// Student's t; in the smooth form with two changes: the variance is shrunk half way towards that of
// neighbouring moments (five values tell little of a variance; two tell none, so that all values of
// a kind at these moments are pooled), and the half width never falls below the error of the
// measurement (all replicates start alike, so the thesis's interval is almost empty at first).
#pragma once

#include "datasets/experiment/experiment.h"

namespace graintruth::calibrate {

double pseudo_huber(double z);
double loss_of(datasets::ObjectiveForm form, double z);

}  // namespace graintruth::calibrate
