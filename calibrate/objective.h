// What the optimiser minimises where tracks are compared: a loss of the distance between the
// simulated mean and the replicates' mean, in units of the replicates' interval.
//
//   z = (simulated mean - replicate mean) / h,   J = mean of rho(z) over all tests
//   smooth      rho(z) = sqrt(1 + (z/2)^2) - 1
//   requested   rho(z) = 1 where |z| > 1, else 0: J is one minus the agreement (eqs 4.2, 4.3)
//
// The smooth rho grows linearly far out, so that one particle that goes astray does not rule the
// fit (Huber 1964). The requested one is as rough as it is plain: it does not tell near from far.
#pragma once

#include <span>
#include <vector>

#include "calibrate/measure.h"
#include "datasets/experiment.h"

namespace graintruth::calibrate {

// Interval half widths h, and the loss that goes with them.
struct HalfWidths {
  std::vector<std::array<double, 3>> half_width;  // m, m, rad; frame-major
  datasets::ObjectiveForm form = datasets::ObjectiveForm::smooth;
};

// The smooth rho(z) of the text above.
double pseudo_huber(double z);

// Half widths of the smooth form, from the replicates and from the measurement error of their
// tracks (standard deviations of single positions, where known), with two changes against eq 4.2:
// the variance is shrunk half way towards that of neighbouring frames (five values tell little of a
// variance), and h never falls below the error of the measurement (all replicates start alike, so
// the thesis's interval is almost empty at first).
// Of `left_out` more replicates the mean knows, the variance does not.
HalfWidths smooth_half_widths(const Band& replicates,
                              std::span<const datasets::Trajectories> tracks,
                              int left_out = 0);

// Half widths of the requested form: eq 4.2 with Student's t, as the agreement has them. Where
// replicates do not differ at all nothing is compared.
HalfWidths agreement_half_widths(const Band& replicates, int left_out = 0);

// z of the text above, frame after frame, for every value that can be compared; never NaN. How many
// there are depends on the replicates only.
std::vector<double> residuals(const datasets::Trajectories& replicate_mean,
                              const HalfWidths& widths,
                              const datasets::Trajectories& simulated_mean);

// J of these residuals.
double mean_loss(datasets::ObjectiveForm form, std::span<const double> residuals);

// J of the text above; never NaN. Where the simulation has no value the distance counts as that of
// a particle that stayed at its measured first place.
double objective(const datasets::Trajectories& replicate_mean,
                 const HalfWidths& widths,
                 const datasets::Trajectories& simulated_mean);

// J of a model in which nothing moves: what a simulation scores that did not complete.
double objective_of_rest(const datasets::Trajectories& replicate_mean, const HalfWidths& widths);

}  // namespace graintruth::calibrate
