// A batch of touching contacts, one column per quantity: the contact law runs along the columns,
// several contacts at a time.
#pragma once

#include <array>
#include <vector>

#include "sim/engine/bodies.h"
#include "sim/engine/columns.h"
#include "sim/engine/wall_touches.h"
#include "sim/laws/contact_law.h"

namespace graintruth::sim {

// What a contact did at the last step.
constexpr int kOpen = 0, kTouching = 1, kSliding = 2;  // kSliding only with static friction

// Rows of a batch: few enough for what is used of them to stay in the first-level cache.
constexpr int kBatchRows = 128;

// Columns a power of two apart would fight for the same few places in the cache: each is a line
// longer than its rows.
struct alignas(64) BatchNumbers : std::array<double, kBatchRows + 8> {};
using BatchScalars = ScalarColumn<BatchNumbers>;
template <int D>
using BatchVectors = VectorColumn<D, BatchNumbers>;
template <int D>
using BatchTangents = TangentColumn<D, BatchNumbers>;

// Of laws with a memory: what the contact carries on, and what its rolling gave.
template <int D>
struct RememberedContact {
  ContactMemory<D> memory;
  double elastic_force = 0.0;  // N
  RollingResistance<D> rolling = {Motion<D>::no_tangent(), Motion<D>::no_tangent(), 0.0};
};

// The law runs along whole vectors of rows: behind the last contact there are copies of it, up to
// the next multiple of so many rows, whose results nobody looks at.
constexpr int kRowsTogether = 8;
inline int whole_rows(int count) { return (count + kRowsTogether - 1) & -kRowsTogether; }

// A contact of a body with the parts of a wall body, as the others of them see it.
template <int D>
struct WallPush {
  typename Motion<D>::Vector normal;
  double stiffness;  // N/m
};

template <int D>
struct ContactBatch {
  int count = 0;
  bool is_of_one_pair = false;  // all rows of the same pair of materials
  int longest_group = 0;        // rows

  // Gathered
  std::array<int, kBatchRows> candidate;                // in the contact list
  std::array<int, kBatchRows> first_body, second_body;  // the second may be a wall
  std::array<int, kBatchRows> was_touching;             // kOpen, kTouching or kSliding
  std::array<int, kBatchRows> carries_on;  // with walls: the candidate whose spring goes on
  std::array<int, kBatchRows> pair;        // index into the pair materials
  BatchScalars group;                      // contacts of the same two partners have the same number
  BatchVectors<D> first_sphere;            // m; its centre
  BatchVectors<D> second_sphere;           // m; its centre (not with walls)
  BatchScalars radius;                     // m; of the first sphere
  BatchScalars second_radius;              // m; (not with walls)
  MotionColumns<D, BatchNumbers> first, second;  // a wall's is that of its point at the origin
  double slip_time = 0.0;     // s; how long the velocities have acted on all that touched before
  BatchScalars inverse_mass;  // 1/kg; 1/m*
  BatchScalars first_turn, second_turn;  // 1/(kg m2); least_turn of the bodies, of a wall 0
  BatchTangents<D> spring_before;        // m
  // 1 where the second body goes with its velocity, 0 for walls, whose point at the origin stays
  double second_goes = 1.0;

  // Geometry of the contact
  BatchScalars overlap;                          // m
  BatchScalars reduced_radius;                   // m; R*
  BatchVectors<D> normal;                        // unit, from first to second
  BatchScalars stiffness;                        // N/m; tangent
  BatchScalars sum_of_stiffness, contact_count;  // of the group; the count under one law alone

  // What follows from place and motion alone
  BatchVectors<D> lever;              // m; from the centre of the first body to the contact point
  BatchTangents<D> slip;              // m; since the last step
  BatchScalars pressure_gained;       // N; in half a step
  BatchTangents<D> speed_gained;      // m/s; across the normal, in half a step
  BatchScalars viscosity;             // N s/m; of the normal dashpot
  BatchScalars tangential_stiffness;  // N/m

  // What the law gives
  BatchTangents<D> spring;            // m; advanced
  BatchScalars ends;                  // within the step, 1 or 0
  BatchScalars normal_force;          // N
  BatchTangents<D> tangential_force;  // N
  BatchScalars slides;                // 1 or 0
  BatchScalars normal_speed;          // m/s
  BatchTangents<D> tangential_speed;  // m/s
  BatchVectors<D> force;              // N, on the second body
  BatchTangents<D> moment;            // N m; of it about the first body's centre
  BatchTangents<D> second_moment;     // N m; about the second's, or the origin with walls

  // The same row by row; the first body gets the opposite of its own
  std::array<Load<D>, kBatchRows> on_first, on_second;

  // Only of laws that need it
  std::array<RememberedContact<D>, kBatchRows> remembered;

  // What touches walls, of the whole slab, and of one group
  std::vector<WallTouch<D>> wall_touches;
  std::vector<WallPush<D>> wall_pushes;
};

// m; from the centre of the first body to the contact point, in the middle of the overlap.
template <int D>
inline typename Motion<D>::Vector lever_of(const ContactBatch<D>& batch, int k) {
  const auto arm = batch.first_sphere.at(k) - batch.first.position.at(k);
  return arm + (batch.radius.at(k) - 0.5 * batch.overlap.at(k)) * batch.normal.at(k);
}

// m/s; how the second surface moves relative to the first at the contact point, by the velocities
// that are predicted for now: that of the second body where the first one's centre is, and the
// difference of the spins
//   u(lever) = u(0) + (w_2 - w_1) x lever,   u(0) = v_2 + w_2 x (x_1 - x_2) - v_1
template <int D>
[[gnu::always_inline]] inline typename Motion<D>::Vector predicted_motion(
    const ContactBatch<D>& batch, int k, typename Motion<D>::Vector lever) {
  const auto offset = batch.first.position.at(k) - batch.second.position.at(k);
  const auto spin = batch.second.spin_now.at(k);
  return batch.second.velocity_now.at(k) + spin_velocity(spin, offset) -
         batch.first.velocity_now.at(k) + spin_velocity(spin - batch.first.spin_now.at(k), lever);
}

}  // namespace graintruth::sim
