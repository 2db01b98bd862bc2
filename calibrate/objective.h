// The smooth companion of the agreement, which the optimiser minimises: pseudo-Huber loss of the
// distance between the simulated mean and the replicates' mean, in units of the replicates'
// interval.
//
//   z = (simulated mean - replicate mean) / h,   rho(z) = sqrt(1 + (z/2)^2) - 1,   J = mean of rho
//   over all tests
//
// rho grows linearly far out, so that one particle that goes astray does not rule the fit (Huber
// 1964).
#pragma once

#include <span>
#include <vector>

#include "calibrate/measure.h"

namespace graintruth::calibrate {

// Interval half widths h of the smooth objective, with two changes against eq 4.2: the variance is
// shrunk half way towards that of neighbouring frames (five values tell little of a variance), and
// h never falls below the error of the measurement (all replicates start alike, so the thesis's
// interval is almost empty at first).
struct HalfWidths {
  std::vector<std::array<double, 3>> half_width;  // m, m, rad; frame-major
};

// rho(z) of the text above.
double pseudo_huber(double z);

// Half widths from the replicates and from the measurement error of their tracks (standard
// deviations of single positions, where known).
HalfWidths smooth_half_widths(const Band& replicates,
                              std::span<const datasets::Trajectories> tracks);

// z of the text above, frame after frame, for every value that can be compared; never NaN. How many
// there are depends on the replicates only.
std::vector<double> residuals(const datasets::Trajectories& replicate_mean,
                              const HalfWidths& widths,
                              const datasets::Trajectories& simulated_mean);

// J of the text above; never NaN. Where the simulation has no value the distance counts as that of
// a particle that stayed at its measured first place.
double objective(const datasets::Trajectories& replicate_mean,
                 const HalfWidths& widths,
                 const datasets::Trajectories& simulated_mean);

// J of a model in which nothing moves: what a simulation scores that did not complete.
double objective_of_rest(const datasets::Trajectories& replicate_mean, const HalfWidths& widths);

}  // namespace graintruth::calibrate
