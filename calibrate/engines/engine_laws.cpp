#include "calibrate/engines/engine_laws.h"

#include <cmath>

#include "sim/laws/restitution.h"

namespace graintruth::calibrate {

namespace {

using sim::Tension;

// With the dashpot of one contact c = 2 sqrt(5/6) beta sqrt(k m*), n equal contacts make
//   n c = 2 sqrt(5/6) (beta sqrt(n)) sqrt(n k m*)
// so the clump rebounds as one contact with damping ratio beta sqrt(n).
double rebound_of(double damping_ratio, int contacts, Tension tension) {
  return sim::restitution_of(damping_ratio * std::sqrt(contacts), tension);
}

}  // namespace

// LIGGGHTS takes beta = -ln e / sqrt(ln^2 e + pi^2)  (Antypov and Elliott 2011)
double liggghts_rebound(double restitution, int contacts) {
  return rebound_of(
      sim::damping_ratio_for(restitution, Tension::allowed), contacts, Tension::allowed);
}

// LAMMPS takes c = a sqrt(k_s m*) with the polynomial a(e) of its pair_granular documentation and
// the secant stiffness k_s = F/d = (2/3) k_n; as Tsuji's c is 2 sqrt(5/6) beta sqrt(k_n m*),
// beta = a / sqrt(5).
double lammps_rebound(double restitution, int contacts) {
  constexpr double coefficients[] = {
      4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728};  // of e^6, e^5, ...
  double a = 0.0;
  for (const double coefficient : coefficients) a = a * restitution + coefficient;
  return rebound_of(a / std::sqrt(5.0), contacts, Tension::allowed);
}

// YADE takes the damping ratio that is right for contacts that never pull, as its own do, but the
// mass of the sphere where that of the clump belongs. Above 0.98 it damps a little more than that
// (0.989 where it is asked for 0.999).
double yade_rebound(double restitution, int contacts, double mass_share) {
  const double ratio = sim::damping_ratio_for(restitution, Tension::clipped);
  return rebound_of(ratio * std::sqrt(mass_share), contacts, Tension::clipped);
}

std::optional<double> restitution_to_ask(const std::function<double(double)>& rebound,
                                         double wanted) {
  constexpr double least = 1e-3, most = 1.0;
  if (wanted < rebound(least) || wanted > rebound(most)) return std::nullopt;
  double low = least, high = most;  // the rebound grows with what is asked for
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    (rebound(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace graintruth::calibrate
