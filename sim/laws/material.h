// Elastic materials, what happens between two of them, and the mixing rules of Hertz and Mindlin
// contacts.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace graintruth::sim {

// Young's modulus in Pa; infinity makes a rigid body (the default wall).
struct Material {
  double youngs_modulus = 0.0;
  double poisson_ratio = 0.0;
};

inline Material rigid_material() { return {std::numeric_limits<double>::infinity(), 0.0}; }

double shear_modulus(const Material& material);

// What a pair of surfaces adds to the elasticity of its two bodies.
struct Surfaces {
  double friction = 0.0;     // -; Coulomb, dynamic
  double restitution = 1.0;  // -; rebound speed over impact speed of a central impact, in (0, 1]
  // -; Coulomb, holds a contact that has not slid since it last stuck; 0: the same as `friction`
  double static_friction = 0.0;
  // -; mu_r: the moment against rolling is at most mu_r times the normal force times R* (that of
  // the two spheres, at a wall the sphere's own radius)
  double rolling_friction = 0.0;
};

// May a damped contact pull? A cohesionless bed cannot, so the force is cut off at zero unless the
// caller wants the unclipped law of the thesis. Restitution comes out as asked in both cases.
enum class Tension { clipped, allowed };

// How the dashpots of several simultaneous contacts between the same two bodies share the damping
// (thesis 3.4). inv_sqrt_n gives the asked restitution for any number of contacts; the others are
// kept for comparison.
enum class DampingSharing { inv_sqrt_n, inv_n, none };

// Spring along the normal, k_n = dF/d(overlap) of Hertz:
//   hertz        F = (2/3) k_n d, Hertz's force on the total overlap
//   linear       F = k d with one constant stiffness for all contacts
//   secant       F = k_n d: the tangent stiffness taken for a secant (thesis 1.72), 1.5 times as
//   stiff incremental  F += k_n(F) dd from step to step (thesis 1.54-1.55). It forgets the overlap,
//   so
//                bodies at rest drift into each other or apart: to show just that (tables 3.1-3.3)
enum class NormalSpring { hertz, linear, secant, incremental };

// Spring across the normal:
//   mindlin         F_t = k_t s with k_t of Mindlin, which follows the pressure
//   mindlin_scaled  the same, but what was stretched under less pressure keeps its force when the
//                   pressure grows (F_t += k_t ds), and loses force with k_t when it falls. No
//                   cycle of pressing and slipping makes energy
//   constant        one constant stiffness for all contacts
enum class TangentialSpring { mindlin, mindlin_scaled, constant };

// What Coulomb's limit limits (thesis fig. 1.4). whole: spring and dashpot together, at mu times
// the whole normal force (variant a); spring: the spring alone, at mu times the normal spring's
// force, the dashpot is added after it (variant b).
enum class CoulombLimit { whole, spring };

// exact: the dashpot that rebounds as asked. thesis: c_n = 2 beta sqrt(k_n m*) with the beta of a
// linear spring (thesis 1.20-1.21), which rebounds less than asked: 0.837 for 0.85, 0.477 for 0.5
// when the contact may pull. Offered to compare with the thesis.
enum class DampingForm { exact, thesis };

// The mixed constants of one pair of materials, ready for the contact law.
struct PairMaterial {
  double normal_modulus = 0.0;      // Pa; E*
  double tangential_ratio = 0.0;    // -; k_t / k_n
  double friction = 0.0;            // -
  double static_friction = 0.0;     // -; not below friction
  double rolling_friction = 0.0;    // -
  double damping_ratio = 0.0;       // -; beta
  double normal_damping = 0.0;      // -; 2 sqrt(5/6) beta; 2 beta for a linear spring
  double tangential_damping = 0.0;  // -; factor on the normal dashpot constant
};

// Of every pair of materials, by index first * materials + second.
using PairTable = std::vector<PairMaterial>;

//   1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2                     (thesis 1.5, Hertz 1882)
//   1/G* = (2 - nu1)/G1 + (2 - nu2)/G2,  k_t/k_n = 4 G*/E*     (thesis 1.14, Mindlin and
//   Deresiewicz 1953)
// `tangential_damping_ratio` scales the tangential dashpot: 1 for the same damping ratio as the
// normal one, 0 for none. Throws std::invalid_argument for unphysical constants or when both bodies
// are rigid.
PairMaterial mix(const Material& first,
                 const Material& second,
                 const Surfaces& surfaces,
                 Tension tension,
                 double tangential_damping_ratio,
                 NormalSpring spring = NormalSpring::hertz,
                 DampingForm form = DampingForm::exact);

// Throw std::invalid_argument naming the field, its value and the rule it breaks.
void check(const Material& material);
void check(const Surfaces& surfaces);

}  // namespace graintruth::sim
