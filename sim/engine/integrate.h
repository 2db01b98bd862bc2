// One leapfrog step of rigid bodies, in the layer or in space.
#pragma once

#include "sim/engine/bodies.h"
#include "sim/engine/team.h"

namespace graintruth::sim {

// What one step does with velocities. Global damping f (1/s), centred (thesis 1.82-1.83 with
// gravity put back):
//   v(N+1/2) = [v(N-1/2) (1 - f dt/2) + a dt] / (1 + f dt/2)
//   v(N+1) = v(N+1/2) + (a - f v) dt/2                         predicted
struct StepFactors {
  double time_step = 0.0;
  double half = 0.0;     // s; dt/2
  double keep = 1.0;     // -; (1 - f dt/2)/(1 + f dt/2)
  double gain = 0.0;     // s; dt/(1 + f dt/2)
  double predict = 1.0;  // -; 1 - f dt/2
};

inline StepFactors step_factors(double time_step, double global_damping) {
  const double loss = 0.5 * global_damping * time_step;
  return {time_step,
          0.5 * time_step,
          (1.0 - loss) / (1.0 + loss),
          time_step / (1.0 + loss),
          1.0 - loss};
}

// How far the surface of a body may come in one step, and how far its accelerations take it.
struct StepLimit {
  double move = 0.0;  // m
  double turn = 0.2;  // rad; up to here the series for sine and cosine are exact to round-off
};
struct StepBound {
  double largest_move = 0.0;  // m; no surface point goes farther
  int suspects = 0;           // bodies that may exceed the limit, or whose motion is not finite
};

// Accelerations of all bodies under their loads:
//   a = f/m + g                      (thesis 2.11)
//   I dw/dt = M - w x (I w)          about principal axes (thesis 2.15 with w w in place of the
//                                    accelerations); about y alone in the plane
// The gyroscopic term takes w in the middle of the step, [w(N-1/2) + w(N+1/2)]/2, by fixed-point
// iteration: without a moment both the energy and |L| are then kept to round-off. Moves nothing.
// A team shares the bodies; without one the caller does all. The bits are the same.
StepBound find_accelerations(const Vec2& gravity,
                             const StepFactors& step,
                             const StepLimit& limit,
                             Bodies<2>& bodies,
                             Team* team = nullptr);
StepBound find_accelerations(const Vec3& gravity,
                             const StepFactors& step,
                             const StepLimit& limit,
                             Bodies<3>& bodies,
                             Team* team = nullptr);

// Advances all bodies by one step and places their spheres:
//   v(N+1/2) = v(N-1/2) + a dt,  r(N+1) = r(N) + v(N+1/2) dt   (thesis 2.16, 2.18)
// and the same for spins, which turn the body through w dt. Velocities at the new time are
// predicted from the accelerations.
void advance(const StepFactors& step, Bodies<2>& bodies, Team* team = nullptr);
void advance(const StepFactors& step, Bodies<3>& bodies, Team* team = nullptr);

// Speed and spin that body i would have half a step on, m/s and rad/s.
struct Speeds {
  double linear, angular;
};
Speeds next_speeds(const StepFactors& step, const Bodies<2>& bodies, int i);
Speeds next_speeds(const StepFactors& step, const Bodies<3>& bodies, int i);

// At the start and after a change of the time step: the half-step velocities are those `later` (s),
//   v + (a - f v) later
void shift_half_step(double later, double global_damping, Bodies<2>& bodies);
void shift_half_step(double later, double global_damping, Bodies<3>& bodies);

}  // namespace graintruth::sim
