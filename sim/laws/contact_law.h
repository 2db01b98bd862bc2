// The contact law, its only copy: Hertz springs on the total overlap, simplified Mindlin springs,
// Tsuji dashpots, Coulomb's limit. Particle on particle and particle on wall alike.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "sim/laws/elementary.h"
#include "sim/laws/material.h"
#include "sim/laws/motion.h"

namespace graintruth::sim {

// Tangent stiffness of a Hertz contact, N/m:  k_n = dF/d(overlap) = 2 E* sqrt(R* overlap)
// (thesis 1.8, Hertz 1882). `stiffness_factor` = 2 E* sqrt(R*).
inline double hertz_stiffness(double stiffness_factor, double overlap) {
  return stiffness_factor * std::sqrt(overlap);
}
inline double hertz_stiffness(const PairMaterial& pair, double reduced_radius, double overlap) {
  return 2.0 * pair.normal_modulus * std::sqrt(reduced_radius * overlap);
}
inline double stiffness_factor_of(const PairMaterial& pair, double reduced_radius) {
  return 2.0 * pair.normal_modulus * std::sqrt(reduced_radius);
}

// Elastic force from the total overlap, N; pushes apart.  F = (4/3) E* sqrt(R*) d^1.5 = (2/3) k_n d
// (thesis 1.1).
inline double hertz_force(double stiffness, double overlap) {
  return (2.0 / 3.0) * stiffness * overlap;
}

// Energy stored in it, J:  (8/15) E* sqrt(R*) d^2.5 = (4/15) k_n d^2
inline double hertz_energy(double stiffness, double overlap) {
  return (4.0 / 15.0) * stiffness * overlap * overlap;
}

// Which law: the default one is fixed when the program is compiled, so that its loop has no
// branches; any other is chosen when the simulation starts. Both run through the same functions.
struct DefaultLaw {
  static constexpr NormalSpring normal_spring = NormalSpring::hertz;
  static constexpr TangentialSpring tangential_spring = TangentialSpring::mindlin;
  static constexpr CoulombLimit coulomb_limit = CoulombLimit::whole;
  static constexpr bool has_static_friction = false, has_rolling_friction = false;
  static constexpr Tension tension = Tension::clipped;
  static constexpr DampingSharing sharing = DampingSharing::inv_sqrt_n;
  static constexpr double linear_stiffness = 0.0, tangential_stiffness = 0.0;
};
struct ChosenLaw {
  NormalSpring normal_spring = DefaultLaw::normal_spring;
  TangentialSpring tangential_spring = DefaultLaw::tangential_spring;
  CoulombLimit coulomb_limit = DefaultLaw::coulomb_limit;
  bool has_static_friction = DefaultLaw::has_static_friction;
  bool has_rolling_friction = DefaultLaw::has_rolling_friction;
  Tension tension = DefaultLaw::tension;
  DampingSharing sharing = DefaultLaw::sharing;
  double linear_stiffness = 0.0;      // N/m; of NormalSpring::linear
  double tangential_stiffness = 0.0;  // N/m; of TangentialSpring::constant
  bool operator==(const ChosenLaw&) const = default;
  // Whether contacts must carry on more than their tangential spring.
  bool needs_memory() const {
    return has_rolling_friction || normal_spring == NormalSpring::incremental ||
           tangential_spring == TangentialSpring::mindlin_scaled;
  }
};

// What a contact carries on from step to step besides its tangential spring, under laws that need
// it.
template <int D>
struct ContactMemory {
  double elastic_force = 0.0;  // N; of NormalSpring::incremental
  double stiffness = 0.0;      // N/m; k_t, of TangentialSpring::mindlin_scaled
  typename Motion<D>::Tangent rolled = Motion<D>::no_tangent();  // rad; of the second on the first
};

// Elastic force, N, and the energy stored in it, J.
//   Hertz   F = (2/3) k_n d,  W = (4/15) k_n d^2     linear   F = k d,  W = k d^2 / 2
//   secant  F = k_n d,        W = (2/5) k_n d^2
// The incremental force does not follow from the overlap, see incremental_force.
template <class Law>
inline double elastic_force(const Law& law, double stiffness, double overlap) {
  return law.normal_spring == NormalSpring::hertz ? hertz_force(stiffness, overlap)
                                                  : stiffness * overlap;
}
template <class Law>
inline double elastic_energy(const Law& law, double stiffness, double overlap) {
  if (law.normal_spring == NormalSpring::secant) return 0.4 * stiffness * overlap * overlap;
  return law.normal_spring == NormalSpring::hertz ? hertz_energy(stiffness, overlap)
                                                  : 0.5 * stiffness * overlap * overlap;
}

// dF/d(overlap), N/m, from k_n.
template <class Law>
inline double force_gain(const Law& law, double stiffness) {
  return law.normal_spring == NormalSpring::secant ? 1.5 * stiffness : stiffness;
}

// Thesis 1.54-1.55 with a signed approach:  F(N) = F(N-1) + k_n(F(N-1)) dd,  not below zero.
// k_n = 2 E* a of the contact radius that belongs to the force:  k_n = c (1.5 F/c)^(1/3),
// c = 2 E* sqrt(R*). Without a force there is no stiffness either: such a contact starts from
// Hertz's force on its overlap.
inline double incremental_force(double before,
                                double approach,
                                double stiffness_factor,
                                double hertz) {
  if (!(before > 0.0)) return hertz;
  const double stiffness = stiffness_factor * exact_cbrt(1.5 * before / stiffness_factor);
  return std::max(before + stiffness * approach, 0.0);
}
// J; stored in Hertz's spring at that force:  (2/5) F d(F)
inline double energy_of_force(double force, double stiffness_factor) {
  const double root = exact_cbrt(1.5 * force / stiffness_factor);
  return 0.4 * force * root * root;
}
// N/m; k_t
template <class Law>
inline double tangential_stiffness_of(const Law& law, const PairMaterial& pair, double stiffness) {
  return law.tangential_spring == TangentialSpring::constant ? law.tangential_stiffness
                                                             : pair.tangential_ratio * stiffness;
}

// Dashpot constant per stiffness, s: what multiplies k_n (or k_t) of one of `count` simultaneous
// contacts between the same two bodies. K = sum of their stiffnesses, m* = m1 m2/(m1 + m2) from the
// masses of the BODIES, given as 1/m* = 1/m1 + 1/m2.
//   inv_sqrt_n  c_i = 2 sqrt(5/6) beta sqrt(m*/K) k_i     the total is 2 sqrt(5/6) beta sqrt(K m*):
//                                                         restitution as asked
//   none        c_i = 2 sqrt(5/6) beta sqrt(m* k_i)       thesis 1.22, contact by contact
//   inv_n       c_i = the same over the number of contacts
template <class Law>
inline double dashpot_per_stiffness(const Law& law,
                                    double normal_damping,
                                    double inverse_mass,
                                    double sum_of_stiffness,
                                    double stiffness,
                                    double count) {
  if (law.sharing == DampingSharing::inv_sqrt_n) {
    return normal_damping / std::sqrt(inverse_mass * sum_of_stiffness);
  }
  const double alone = normal_damping / std::sqrt(inverse_mass * stiffness);
  return law.sharing == DampingSharing::inv_n ? alone / count : alone;
}

// Relative motion of the two surfaces at the contact point, second body minus first
// (thesis 1.36, 1.45-1.46).
template <int D>
struct SurfaceMotion {
  double normal_speed;                     // m/s along the normal; below zero while approaching
  typename Motion<D>::Tangent tangential;  // m/s, now: drives the dashpot
  typename Motion<D>::Tangent slip;        // m, since the last step: stretches the spring
};

// What changes within half a step, before now and after. With it the law keeps its limits all
// through a step, not only at its middle: where a force falls below zero, or comes to its limit,
// the mean of the step is not the value of now. All zero: now alone counts.
template <int D>
struct HalfStep {
  double duration;                       // s
  double normal_force;                   // N; before it is clipped
  typename Motion<D>::Tangent velocity;  // m/s; across the normal
};

// Whether the pressure is its mean over a step in which it begins or ends. Where it does neither
// both give the same.
enum class Pressure { of_now, of_step };

// Mean over a step of max(0, x) of an x that grows evenly: by `half` in half a step.
inline double mean_above_zero(double now, double half) {
  const double mean = (now + half) * (now + half) / (4.0 * half);
  const double kept = now > 0.0 ? now : 0.0;
  return std::abs(now) < half ? mean : kept;
}

template <int D>
struct ContactForce {
  double normal;  // N on the second body along the normal (first to second)
  typename Motion<D>::Tangent tangential;  // N on the second body
  bool slides;
  double ends;  // within the step, 1 or 0
};

// Variant b of Coulomb's limit adds the dashpot after it.
template <class Law, class Tangent>
inline Tangent with_late_dashpot(const Law& law,
                                 Tangent force,
                                 double viscosity,
                                 Tangent velocity) {
  if constexpr (std::is_same_v<Law, DefaultLaw>) return force;
  return force - (law.coulomb_limit == CoulombLimit::spring ? viscosity : 0.0) * velocity;
}

// Force of one contact; advances its tangential spring (m, tangential displacement of the second
// body).
//   N = F_el - c_n v_n, not below zero when clipped
//   F_t = -k_t spring - c_t v_t, at most mu N, N with the dashpot (thesis 1.71-1.72, fig. 1.4
//   variant a); when limited, the spring is left with the stretch that carries what the dashpot
//   leaves of mu N, none when that is nothing: so a contact begins to stick without a jump. Variant
//   b limits the spring's part at mu F_el and adds the dashpot after that. With static friction a
//   contact that sticks holds up to mu_s N; once it has slid (`slid_before`) mu counts until it
//   sticks.
// A force that is clipped or limited in a part of the step gives its mean over the step.
// Inlined, or the loop over a batch would not run along several rows at once.
template <Pressure of, int D, class Law>
[[gnu::always_inline]] inline ContactForce<D> contact_force(const Law& law,
                                                            const PairMaterial& pair,
                                                            const SurfaceMotion<D>& motion,
                                                            const HalfStep<D>& half_step,
                                                            typename Motion<D>::Vector normal,
                                                            double overlap,
                                                            double elastic,
                                                            double viscosity,
                                                            double tangential_stiffness,
                                                            bool slid_before,
                                                            typename Motion<D>::Tangent& spring) {
  // 1. Normal spring and dashpot. Below zero only the dashpot can pull it
  const double whole = elastic - viscosity * motion.normal_speed;
  const double falls = whole < elastic ? -half_step.normal_force : 0.0;
  double pressing = whole > 0.0 ? whole : 0.0;
  if constexpr (of == Pressure::of_step) pressing = mean_above_zero(whole, falls);

  // 2. Tangential spring and dashpot
  const auto stretched = turned_into_plane(spring, normal) + motion.slip;
  const double drag = pair.tangential_damping * viscosity;  // N s/m
  const bool limits_whole = law.coulomb_limit == CoulombLimit::whole;
  const double limited_drag = limits_whole ? drag : 0.0;
  const auto damped = limited_drag * motion.tangential;
  const auto trial = -tangential_stiffness * stretched - damped;

  // 3. Coulomb's limit
  const double load = limits_whole ? pressing : elastic;
  const double limit = pair.friction * load;
  const double length = length_of(trial);
  const bool holds =
      law.has_static_friction && !slid_before && length <= pair.static_friction * load;
  const bool slides = length > limit && !holds;
  // One division for both
  const double inverse = 1.0 / (length * tangential_stiffness);
  const double per_length = inverse * tangential_stiffness, per_stiffness = inverse * length;
  const double sliding = limit * per_length;
  const auto carried = sliding * trial + damped;
  const double kept = product_of(carried, trial) > 0.0 ? per_stiffness : 0.0;
  spring = chosen(slides, -kept * carried, stretched);

  // 4. What of it the step sees: the mean of the smaller of trial and limit. k_t grows with the
  // root
  //    of the overlap, unless it is constant or the spring is scaled down as it does. All is
  //    multiplied with overlap and length, so that no division waits for another
  const bool keeps_stiffness =
      law.normal_spring == NormalSpring::linear ||
      law.tangential_spring == TangentialSpring::constant ||
      (law.tangential_spring == TangentialSpring::mindlin_scaled && motion.normal_speed < 0.0);
  const double growth = (keeps_stiffness ? 0.0 : -0.5 * half_step.duration) * motion.normal_speed;
  const auto stretch_gained =
      (half_step.duration * overlap) * motion.tangential + growth * stretched;
  const auto trial_gained =
      -tangential_stiffness * stretch_gained - (limited_drag * overlap) * half_step.velocity;
  const double longer = length * overlap, gap = (limit - length) * longer;
  const double half =
      std::abs((pair.friction * half_step.normal_force) * longer - product_of(trial_gained, trial));
  const double below = (gap + half) * (gap + half) / (4.0 * half * (length * longer));
  const double of_now = slides ? sliding : 1.0;
  const double of_step = sliding > below ? sliding - below : 0.0;
  const bool is_mixed = std::abs(gap) < (law.has_static_friction ? 0.0 : half);
  const auto force = (is_mixed ? of_step : of_now) * trial;
  return {law.tension == Tension::clipped ? pressing : whole,
          with_late_dashpot(law, force, drag, motion.tangential),
          slides,
          std::abs(whole) < falls ? 1.0 : 0.0};
}

// Moment that resists rolling: an elastic-plastic spring and dashpot (Iwashita and Oda 1998; model
// C of Ai et al. 2011). w is the turning of the second body relative to the first, without its part
// about the normal.
//   M = -k_r theta - c_r w, at most M_max = mu_r R* N;   k_r = 2.25 k_n (mu_r R*)^2
//   c_r = 2 beta sqrt(k_r I_r), I_r = 7/5 m* R*^2        that of a ball about its point on a plane
// When limited, the spring is left with the turn that carries M_max, so all work beyond it is lost.
template <int D>
struct RollingResistance {
  typename Motion<D>::Tangent moment;  // N m, on the second body
  typename Motion<D>::Tangent speed;   // rad/s; now
  double stiffness;                    // N m/rad
};
template <int D>
inline RollingResistance<D> rolling_resistance(const PairMaterial& pair,
                                               typename Motion<D>::Tangent turned,
                                               typename Motion<D>::Tangent speed,
                                               typename Motion<D>::Vector normal,
                                               double reduced_radius,
                                               double stiffness,
                                               double reduced_mass,
                                               double pressing,
                                               double dashpot_share,
                                               typename Motion<D>::Tangent& rolled) {
  const double arm = pair.rolling_friction * reduced_radius;  // m
  const double rolling_stiffness = 2.25 * stiffness * arm * arm;
  const auto spring = turned_into_plane(rolled, normal) + without_twist(turned, normal);
  const auto rolling = without_twist(speed, normal);
  const double inertia = 1.4 * reduced_mass * reduced_radius * reduced_radius;  // kg m2
  const double viscosity =
      dashpot_share * 2.0 * pair.damping_ratio * std::sqrt(rolling_stiffness * inertia);
  const auto trial = -rolling_stiffness * spring - viscosity * rolling;
  const double limit = arm * pressing, length = length_of(trial);
  const bool yields = length > limit;
  const double share = yields ? limit / length : 1.0;
  rolled = chosen(yields, (-1.0 / rolling_stiffness) * (share * trial), spring);
  if (rolling_stiffness == 0.0) rolled = Motion<D>::no_tangent();
  return {share * trial, rolling, rolling_stiffness};
}

}  // namespace graintruth::sim
