// How long a time step may be, from stiffness, mass and the duration of a contact.
#pragma once

#include <string>

#include "sim/scene.h"

namespace graintruth::sim {

// Rayleigh time step, s:  pi R sqrt(rho/G) / (0.1631 nu + 0.8766)   (thesis 1.28, with the pi that
// its numbers lack).
double rayleigh_time_step(double radius, double density, const Material& material);

// Stability limit of the leapfrog for one spring, s:  2 sqrt(m/k)   (thesis 1.24 corrected).
double stiffness_time_step(double mass, double stiffness);

// An elastic Hertz impact: k = 4/3 E* sqrt(R*), deepest overlap (5 m* v^2/(4 k))^(2/5),
// duration 2.9432751843 of it over v.
struct HertzImpact {
  double deepest_overlap = 0.0;  // m
  double largest_force = 0.0;    // N
  double duration = 0.0;         // s
};
HertzImpact hertz_impact(double normal_modulus,
                         double reduced_radius,
                         double reduced_mass,
                         double speed);

struct TimeStepLimits {
  double rayleigh = 0.0;   // s; smallest over bodies
  double stiffness = 0.0;  // s; smallest over contacts at the deepest overlap of the stated impact
  double contact_duration = 0.0;  // s; shortest impact at the stated speed
  double refined_duration = 0.0;  // s; the same, of which that of impacts without loss is a fifth
};

// Over all types, pairs of types and walls of a scene. `impact_speed` (m/s) is the fastest
// collision that must be resolved.
TimeStepLimits time_step_limits(const Scene& scene, double impact_speed);

// The Rayleigh step of the scene, s: fraction 1.
double critical_time_step(const Scene& scene);

// How many times as many steps a contact gets that hardly loses energy. The touch falls anywhere
// within a step, so an elastic impact rebounds with up to 4e-4 of its speed too much or too little
// at 20 steps. These errors go with the square of the step and cancel to first order, but their
// squares do not: impact by impact the energy grows by 2e-6 of itself, with the fourth power of the
// step. Where an impact is meant to lose 2e-3 or more that is nothing; without loss it is all. At
// 100 steps it is below 1e-8.
constexpr double kStepsWithoutLoss = 5.0;
constexpr double kHardlyLoses = 0.999;  // restitution

struct TimeStepOptions {
  double fraction = 0.5;  // -; of the Rayleigh step; a convergence control, not a material constant
  double impact_speed = 0.1;  // m/s; fastest collision that is resolved with at least ...
  // -; ... this many steps (model specification 11), and five times as many where surfaces that may
  // meet rebound with more than 0.999 (see kStepsWithoutLoss)
  double steps_per_contact = 20.0;
  double largest = 0.0;  // s; a further cap, 0 for none
};

// Smallest of fraction times Rayleigh, contact duration over steps per contact, half the stiffness
// limit, and the cap. Throws std::invalid_argument for a fraction outside (0, 1] or other values
// that are not above zero.
double choose_time_step(const Scene& scene, const TimeStepOptions& options);

// The same for springs of one constant stiffness (N/m): contact duration pi sqrt(m*/k) over steps
// per contact, and half the stiffness limit.
double linear_time_step(const Scene& scene, double stiffness, const TimeStepOptions& options);

}  // namespace graintruth::sim
