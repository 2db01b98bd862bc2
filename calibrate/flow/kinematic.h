// The kinematic model of a discharging bed (Litwiniszyn 1963; Mullins 1972; Nedderman and Tuzun
// 1979): downward velocity spreads like heat, dv/dh = B d2v/dx2, with a length B of the order of a
// particle.
#pragma once

#include <span>

namespace graintruth::calibrate {

// Downward velocity at a place across the bed. Signs: v is positive downwards.
struct VelocitySample {
  double x = 0.0;                     // m, from the orifice's middle
  double velocity = 0.0;              // m/s
  double standard_uncertainty = 0.0;  // m/s; 0 where unknown
};

struct KinematicOptions {
  double height = 0.0;   // m, of the profile above the orifice
  double orifice = 0.0;  // m, its width; 0: a point, the thesis's form (eq 4.8)
  // Velocity on the axis (point form) or in the orifice (finite form), m/s; 0: fitted too. The
  // thesis pins it to the value at the centre.
  double pinned_velocity = 0.0;
};

struct KinematicFit {
  double B = 0.0;                   // m
  double lower = 0.0, upper = 0.0;  // m; 95 % by profile likelihood. 0 or infinity: open
  double velocity = 0.0;            // m/s, v0 of the form
  double rms = 0.0;                 // m/s, of the residuals
  int freedom = 0;
  // A B fits best, not one at an end of what was sought: from profiles far narrower than the
  // samples' spacing to some far wider than the bed.
  bool converged = false;
  bool is_too_flat = false;  // where not converged: the best B is the largest
};

//   point    v = v0 exp(-x^2 / 4Bh)
//   finite   v = (v0 / 2) [erf((D/2 - x) / sqrt(4Bh)) + erf((D/2 + x) / sqrt(4Bh))]
double kinematic_velocity(const KinematicOptions& options, double B, double v0, double x);

// Needs three samples, or two with a pinned velocity. Weighted where the samples have
// uncertainties: all of them, or none, else std::invalid_argument is thrown.
KinematicFit fit_kinematic(std::span<const VelocitySample> samples,
                           const KinematicOptions& options);

}  // namespace graintruth::calibrate
