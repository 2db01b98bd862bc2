// One leapfrog step of a rigid body, in the layer or in space.
#pragma once

#include "sim/bodies.h"

namespace graintruth::sim {

// What one step does with velocities. Global damping f (1/s), centred (thesis 1.82-1.83 with
// gravity put back):
//   v(N+1/2) = [v(N-1/2) (1 - f dt/2) + a dt] / (1 + f dt/2)
struct StepFactors {
  double time_step = 0.0;
  double half = 0.0;  // s; dt/2
  double keep = 1.0;  // -; (1 - f dt/2)/(1 + f dt/2)
  double gain = 0.0;  // s; dt/(1 + f dt/2)
};

inline StepFactors step_factors(double time_step, double global_damping) {
  const double loss = 0.5 * global_damping * time_step;
  return {time_step, 0.5 * time_step, (1.0 - loss) / (1.0 + loss), time_step / (1.0 + loss)};
}

// Velocity half a step on, not yet committed.
template <int D>
struct NextVelocity {
  Vec<D> acceleration;  // m/s2
  Vec<D> velocity;      // m/s
};

//   a = f/m + g,  v(N+1/2) = v(N-1/2) + a dt   (thesis 2.11, 2.16)
template <int D>
inline NextVelocity<D> next_velocity(const Bodies<D>& bodies,
                                     int i,
                                     const Vec<D>& gravity,
                                     const StepFactors& step) {
  const Vec<D> acceleration = to_eigen(bodies.load[i].force) * bodies.inverse_mass[i] + gravity;
  return {acceleration, bodies.motion[i].velocity * step.keep + acceleration * step.gain};
}

// Commits it:  r(N+1) = r(N) + v(N+1/2) dt   (thesis 2.18); predicts the velocity at the new time.
template <int D>
inline void move(Bodies<D>& bodies, int i, const NextVelocity<D>& next, const StepFactors& step) {
  BodyMotion<D>& motion = bodies.motion[i];
  bodies.acceleration[i] = next.acceleration;
  motion.velocity = next.velocity;
  motion.velocity_now = next.velocity + step.half * next.acceleration;
  motion.position += next.velocity * step.time_step;
}

// Angular velocity half a step on, not yet committed.
struct NextPlanarSpin {
  double acceleration;  // rad/s2
  double spin;          // rad/s
  double squared() const { return spin * spin; }
};
struct NextSpatialSpin {
  Vec3 acceleration;  // rad/s2, body axes
  Vec3 spin;          // rad/s, body axes
  double squared() const { return spin.squaredNorm(); }
};

//   I dw/dt = M, about y
inline NextPlanarSpin next_spin(const Bodies<2>& bodies, int i, const StepFactors& step) {
  const double acceleration = bodies.load[i].torque * bodies.inverse_inertia[i];
  return {acceleration, bodies.motion[i].spin * step.keep + acceleration * step.gain};
}

// Euler's equations in body axes, I dw/dt = M - w x (I w) (thesis 2.15 with w w in place of the
// accelerations). The gyroscopic term takes w in the middle, [w(N-1/2) + w(N+1/2)]/2, by
// fixed-point iteration: without a moment both the energy and |L| are then kept to round-off.
inline NextSpatialSpin next_spin(const Bodies<3>& bodies, int i, const StepFactors& step) {
  // Each iteration gains a factor w dt: below 1e-2 four of them reach round-off, below 1e-4 two
  constexpr int kIterations = 4, kIterationsOfSlow = 2;
  constexpr double kSlow = 1e-4;  // rad a step
  const Vec3& inverse = bodies.inverse_inertia[i];
  const Vec3& before = bodies.turns.spin_in_body[i];
  Vec3 acceleration;
  if (bodies.is_round[i]) {
    acceleration = to_eigen(bodies.load[i].torque).cwiseProduct(inverse);
  } else {
    const Vec3& inertia = bodies.inertia[i];
    const Vec3 torque =
        bodies.turns.world_from_body[i].conjugate() * to_eigen(bodies.load[i].torque);
    acceleration = bodies.turns.acceleration_in_body[i];
    const bool is_slow = before.squaredNorm() * step.time_step * step.time_step < kSlow * kSlow;
    const int iterations = is_slow ? kIterationsOfSlow : kIterations;
    for (int k = 0; k < iterations; ++k) {
      const Vec3 middle = before + step.half * acceleration;
      const Vec3 momentum = inertia.cwiseProduct(middle);
      acceleration = (torque - middle.cross(momentum)).cwiseProduct(inverse);
    }
  }
  return {acceleration, before * step.keep + acceleration * step.gain};
}

// Commits the spin, turns the body through spin dt and places its spheres; predicts the spin at the
// new time. The body has been moved before.
inline void turn(Bodies<2>& bodies, int i, const NextPlanarSpin& next, const StepFactors& step) {
  bodies.angular_acceleration[i] = next.acceleration;
  bodies.motion[i].spin = next.spin;
  bodies.motion[i].spin_now = next.spin + step.half * next.acceleration;
  const double angle = next.spin * step.time_step;
  bodies.turns.angle[i] += angle;
  const SmallTurn small = small_turn(angle);
  const Vec2 old = bodies.turns.direction[i];
  const Vec2 turned(old.x() * small.cosine - old.y() * small.sine,
                    old.y() * small.cosine + old.x() * small.sine);
  // First-order renormalisation: the length is 1 to round-off already
  bodies.turns.direction[i] = turned * (1.5 - 0.5 * turned.squaredNorm());
  place_spheres(bodies, i);
}

// q(N+1) = q(N) exp(w dt / 2) with w in body axes; exp(w dt / 2) q(N) with w in world axes
inline void turn(Bodies<3>& bodies, int i, const NextSpatialSpin& next, const StepFactors& step) {
  bodies.turns.acceleration_in_body[i] = next.acceleration;
  bodies.turns.spin_in_body[i] = next.spin;
  const HalfTurn half = half_turn(next.spin.squaredNorm() * step.half * step.half);
  const Vec3 vector = next.spin * (step.half * half.sine_over_angle);
  const Quat turn(half.cosine, vector.x(), vector.y(), vector.z());
  const Vec3 spin_now = next.spin + step.half * next.acceleration;
  const Quat before = bodies.turns.world_from_body[i];
  Quat after = bodies.is_round[i] ? turn * before : before * turn;
  // First-order renormalisation: the length is 1 to round-off already
  after.coeffs() *= 1.5 - 0.5 * after.squaredNorm();
  bodies.turns.world_from_body[i] = after;
  if (bodies.is_round[i]) {
    bodies.motion[i].spin = next.spin;
    bodies.motion[i].spin_now = spin_now;
    place_spheres(bodies, i);
  } else {
    const Mat3 world_from_body = after.toRotationMatrix();
    bodies.motion[i].spin = world_from_body * next.spin;
    bodies.motion[i].spin_now = world_from_body * spin_now;
    place_spheres(bodies, i, world_from_body);
  }
}

// After a change of the time step: half-step velocities belong to the new half step.
inline void shift_half_step(Bodies<2>& bodies, int i, double later) {
  bodies.motion[i].velocity += later * bodies.acceleration[i];
  bodies.motion[i].spin += later * bodies.angular_acceleration[i];
}
inline void shift_half_step(Bodies<3>& bodies, int i, double later) {
  bodies.motion[i].velocity += later * bodies.acceleration[i];
  bodies.turns.spin_in_body[i] += later * bodies.turns.acceleration_in_body[i];
  const Vec3& spin = bodies.turns.spin_in_body[i];
  bodies.motion[i].spin = bodies.is_round[i] ? spin : Vec3(bodies.turns.world_from_body[i] * spin);
}

}  // namespace graintruth::sim
