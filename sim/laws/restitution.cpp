#include "sim/laws/restitution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

// Steps per elastic contact duration: the rebound is then right to 1e-7, far below what a run can
// resolve.
constexpr int kStepsPerContact = 2000;
constexpr double kLargestDampingRatio = 100.0;

// The damped impact without dimensions:
//   Hertz    x'' = -x^1.5 - a x^0.25 x',  a = sqrt(5) beta    (Antypov and Elliott 2011)
//   linear   x'' = -x - 2 beta x'
// from x(0) = 0, x'(0) = 1, ended where the force, not the overlap, becomes zero. Fourth-order
// Runge-Kutta.
double clipped_restitution(double damping_ratio, NormalSpring spring) {
  const bool is_linear = spring == NormalSpring::linear;
  const double damping = (is_linear ? 2.0 : std::sqrt(5.0)) * damping_ratio;
  const auto force = [=](double x, double v) {
    if (is_linear) return x + damping * v;
    const double root = std::sqrt(std::max(x, 0.0));
    return x * root + damping * std::sqrt(root) * v;
  };
  // Elastic contact duration: pi; of Hertz 2.943 d_max / v with d_max = (5/4)^(2/5). Strong damping
  // needs a finer step.
  const double duration = is_linear ? std::numbers::pi : 2.9432752 * exact_pow(1.25, 0.4);
  const double longest = duration / kStepsPerContact / (1.0 + damping_ratio);
  double x = 0.0;
  double v = 1.0;
  double time = 0.0;
  double previous_force = 0.0;
  for (int i = 0; i < 1000 * kStepsPerContact; ++i) {
    // x^0.25 is not smooth at the first touch: steps grow from almost nothing
    const double step = std::min(longest, 1e-7 + 0.1 * time);
    time += step;
    const double x1 = v, v1 = -force(x, v);
    const double x2 = v + 0.5 * step * v1, v2 = -force(x + 0.5 * step * x1, x2);
    const double x3 = v + 0.5 * step * v2, v3 = -force(x + 0.5 * step * x2, x3);
    const double x4 = v + step * v3, v4 = -force(x + step * x3, x4);
    const double x_new = x + step / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4);
    const double v_new = v + step / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    const double new_force = force(x_new, v_new);
    if (v_new < 0.0 && new_force <= 0.0) {
      const double share =
          previous_force > new_force ? previous_force / (previous_force - new_force) : 1.0;
      return -(v + share * (v_new - v));
    }
    x = x_new;
    v = v_new;
    previous_force = new_force;
  }
  return std::max(-v, 0.0);
}

// beta = -ln e / sqrt(ln^2 e + pi^2) (thesis 1.20; exact for the unclipped law)
double unclipped_damping_ratio(double restitution) {
  const double log_e = exact_log(restitution);
  return -log_e / std::sqrt(log_e * log_e + std::numbers::pi * std::numbers::pi);
}

}  // namespace

double restitution_of(double damping_ratio, Tension tension, NormalSpring spring) {
  if (damping_ratio == 0.0) return 1.0;
  if (tension == Tension::clipped) return clipped_restitution(damping_ratio, spring);
  return damping_ratio >= 1.0 ? 0.0
                              : exact_exp(-std::numbers::pi * damping_ratio /
                                          std::sqrt(1.0 - damping_ratio * damping_ratio));
}

double damping_ratio_for(double restitution, Tension tension, NormalSpring spring) {
  check(Surfaces{.restitution = restitution});
  if (restitution == 1.0) return 0.0;
  const double unclipped = unclipped_damping_ratio(restitution);
  if (tension == Tension::allowed) return unclipped;

  // 1. Bracket: clipping takes damping away, so the unclipped ratio rebounds too far
  double low = unclipped;
  double low_error = clipped_restitution(low, spring) - restitution;
  double high = low;
  double high_error = low_error;
  while (high_error > 0.0) {
    low = high;
    low_error = high_error;
    high = 1.3 * high;
    if (high > kLargestDampingRatio) {
      throw std::invalid_argument("damping_ratio_for: restitution " + std::to_string(restitution) +
                                  " is too small for a contact that cannot pull");
    }
    high_error = clipped_restitution(high, spring) - restitution;
  }
  // 2. Regula falsi with halving of the kept end (Illinois)
  double ratio = high;
  int kept = 0;
  for (int i = 0; i < 100 && high - low > 1e-9 * high; ++i) {
    ratio = (low * high_error - high * low_error) / (high_error - low_error);
    const double error = clipped_restitution(ratio, spring) - restitution;
    if (std::abs(error) < 1e-9) break;
    if (error > 0.0) {
      low = ratio;
      low_error = error;
      if (kept == 1) high_error *= 0.5;
      kept = 1;
    } else {
      high = ratio;
      high_error = error;
      if (kept == -1) low_error *= 0.5;
      kept = -1;
    }
  }
  return ratio;
}

}  // namespace graintruth::sim
