// A batch of touching contacts, one column per quantity: the contact law runs along the columns,
// several contacts at a time.
#pragma once

#include <array>

#include "sim/columns.h"
#include "sim/contact_law.h"

namespace graintruth::sim {

// What a contact did at the last step.
constexpr int kOpen = 0, kTouching = 1, kSliding = 2;  // kSliding only with static friction

// Rows of a batch: few enough for what is used of them to stay in the first-level cache.
constexpr int kBatchRows = 128;

struct alignas(64) BatchNumbers : std::array<double, kBatchRows> {};
using BatchScalars = ScalarColumn<BatchNumbers>;
template <int D>
using BatchVectors = VectorColumn<D, BatchNumbers>;
template <int D>
using BatchTangents = TangentColumn<D, BatchNumbers>;

// Velocity of the second body (or wall) relative to the first, anywhere on the first: that at the
// first's centre, and the difference of the spins.
//   u(lever) = u(0) + (w_2 - w_1) x lever,   u(0) = v_2 - v_1 + w_2 x (x_1 - x_2)
template <int D>
struct RelativeMotionColumns {
  BatchVectors<D> at_centre;  // m/s
  BatchTangents<D> spin;      // rad/s
};

// Of laws with a memory: what the contact carries on, and what its rolling gave.
template <int D>
struct RememberedContact {
  ContactMemory<D> memory;
  double elastic_force = 0.0;  // N
  RollingResistance<D> rolling = {Motion<D>::no_tangent(), Motion<D>::no_tangent(), 0.0};
};

template <int D>
struct ContactBatch {
  int count = 0;

  // Gathered
  std::array<int, kBatchRows> candidate, group;  // in the contact list
  std::array<int, kBatchRows> was_touching;      // kOpen, kTouching or kSliding
  std::array<int, kBatchRows> pair;              // index into the pair materials
  BatchVectors<D> apart;            // m; between the centres of the two spheres (not with walls)
  BatchScalars distance_squared;    // m2 (not with walls)
  BatchScalars reach;               // m; sum of the radii
  BatchScalars stiffness_factor;    // N/m^1.5; 2 E* sqrt(R*)
  BatchVectors<D> offset;           // m; centre of the first body minus that of the second
  BatchVectors<D> arm;              // m; from the first body's centre to its sphere
  BatchScalars radius;              // m; of that sphere
  RelativeMotionColumns<D> moved;   // half a step back: stretches the springs
  RelativeMotionColumns<D> moving;  // now: drives the dashpots
  BatchScalars slip_time;           // s; how long `moved` has acted on this contact
  BatchScalars reduced_mass;        // kg
  BatchTangents<D> spring;          // m

  // Geometry of the contact
  BatchScalars overlap;                          // m
  BatchVectors<D> normal;                        // unit, from first to second
  BatchScalars stiffness;                        // N/m; tangent
  BatchScalars sum_of_stiffness, contact_count;  // of the group; the count under one law alone

  // What the law gives; `spring` is advanced
  BatchScalars normal_force;          // N
  BatchTangents<D> tangential_force;  // N
  BatchScalars slides;                // 1 or 0
  BatchScalars normal_speed;          // m/s
  BatchTangents<D> tangential_speed;  // m/s
  BatchVectors<D> force;              // N, on the second body
  BatchTangents<D> moment;            // N m; of it about the first body's centre
  BatchTangents<D> second_moment;     // N m; about the second's (not with walls)

  // Only of laws that need it
  std::array<RememberedContact<D>, kBatchRows> remembered;
};

}  // namespace graintruth::sim
