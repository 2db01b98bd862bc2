// The contact law, its only copy: Hertz springs on the total overlap, simplified Mindlin springs,
// Tsuji dashpots, Coulomb's limit. Particle on particle and particle on wall alike.
#pragma once

#include <cmath>

#include "sim/material.h"
#include "sim/motion.h"

namespace graintruth::sim {

// Tangent stiffness of a Hertz contact, N/m:  k_n = dF/d(overlap) = 2 E* sqrt(R* overlap)
// (thesis 1.8, Hertz 1882). `stiffness_factor` = 2 E* sqrt(R*).
inline double hertz_stiffness(double stiffness_factor, double overlap) {
  return stiffness_factor * std::sqrt(overlap);
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
  static constexpr Tension tension = Tension::clipped;
  static constexpr DampingSharing sharing = DampingSharing::inv_sqrt_n;
};
struct ChosenLaw {
  Tension tension = Tension::clipped;
  DampingSharing sharing = DampingSharing::inv_sqrt_n;
};

// Dashpot constant per stiffness, s: what multiplies k_n (or k_t) of one of `count` simultaneous
// contacts between the same two bodies. K = sum of their stiffnesses, m* = m1 m2/(m1 + m2) from the
// masses of the BODIES.
//   inv_sqrt_n  c_i = 2 sqrt(5/6) beta sqrt(m*/K) k_i     the total is 2 sqrt(5/6) beta sqrt(K m*):
//                                                         restitution as asked
//   none        c_i = 2 sqrt(5/6) beta sqrt(m* k_i)       thesis 1.22, contact by contact
//   inv_n       c_i = the same over the number of contacts
template <class Law>
inline double dashpot_per_stiffness(const Law& law,
                                    double normal_damping,
                                    double reduced_mass,
                                    double sum_of_stiffness,
                                    double stiffness,
                                    double count) {
  if (law.sharing == DampingSharing::inv_sqrt_n) {
    return normal_damping * std::sqrt(reduced_mass / sum_of_stiffness);
  }
  const double alone = normal_damping * std::sqrt(reduced_mass / stiffness);
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

template <int D>
struct ContactForce {
  double normal;  // N on the second body along the normal (first to second)
  typename Motion<D>::Tangent tangential;  // N on the second body
  bool slides;
};

// Force of one contact; advances its tangential spring (m, tangential displacement of the second
// body).
//   N = F_el - c_n v_n, not below zero when clipped
//   F_t = -k_t spring - c_t v_t, at most mu N, N with the dashpot (thesis 1.71-1.72, fig. 1.4
//   variant a); when limited, the spring is left with the stretch that carries mu N.
template <int D, class Law>
inline ContactForce<D> contact_force(const Law& law,
                                     const PairMaterial& pair,
                                     const SurfaceMotion<D>& motion,
                                     typename Motion<D>::Vector normal,
                                     double overlap,
                                     double stiffness,
                                     double dashpot,
                                     typename Motion<D>::Tangent& spring) {
  // 1. Normal spring and dashpot
  const double whole = hertz_force(stiffness, overlap) - dashpot * stiffness * motion.normal_speed;
  const double pressing = whole > 0.0 ? whole : 0.0;

  // 2. Tangential spring and dashpot
  const double tangential_stiffness = pair.tangential_ratio * stiffness;
  const auto stretched = turned_into_plane(spring, normal) + motion.slip;
  const auto trial = -tangential_stiffness * stretched -
                     (pair.tangential_damping * dashpot * stiffness) * motion.tangential;

  // 3. Coulomb's limit
  const double limit = pair.friction * pressing;
  const double length = length_of(trial);
  const bool slides = length > limit;
  const ContactForce<D> force{law.tension == Tension::clipped ? pressing : whole,
                              (slides ? limit / length : 1.0) * trial,
                              slides};
  spring = chosen(slides, (-1.0 / tangential_stiffness) * force.tangential, stretched);
  return force;
}

}  // namespace graintruth::sim
