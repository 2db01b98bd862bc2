// A batch of touching contacts, one column per quantity: the contact law runs along the columns,
// several contacts at a time.
#pragma once

#include <array>

#include "sim/motion.h"

namespace graintruth::sim {

// Rows of a batch: few enough for what is used of them to stay in the first-level cache.
constexpr int kBatchRows = 128;

using Numbers = std::array<double, kBatchRows>;

struct ScalarColumn {
  alignas(64) Numbers value;
  double at(int k) const { return value[k]; }
  void set(int k, double v) { value[k] = v; }
};

template <int D>
struct VectorColumn;

template <>
struct VectorColumn<2> {
  alignas(64) Numbers x, z;
  PlanarVector at(int k) const { return {x[k], z[k]}; }
  void set(int k, PlanarVector v) {
    x[k] = v.x;
    z[k] = v.z;
  }
};

template <>
struct VectorColumn<3> {
  alignas(64) Numbers x, y, z;
  SpatialVector at(int k) const { return {x[k], y[k], z[k]}; }
  void set(int k, SpatialVector v) {
    x[k] = v.x;
    y[k] = v.y;
    z[k] = v.z;
  }
};

// Tangential springs and spins: a number in the plane, a vector in space.
template <int D>
struct TangentColumnOf {
  using type = VectorColumn<3>;
};
template <>
struct TangentColumnOf<2> {
  using type = ScalarColumn;
};
template <int D>
using TangentColumn = typename TangentColumnOf<D>::type;

// Velocity of the second body (or wall) relative to the first, anywhere on the first: that at the
// first's centre, and the difference of the spins.
//   u(lever) = u(0) + (w_2 - w_1) x lever,   u(0) = v_2 - v_1 + w_2 x (x_1 - x_2)
template <int D>
struct RelativeMotionColumns {
  VectorColumn<D> at_centre;  // m/s
  TangentColumn<D> spin;      // rad/s
};

template <int D>
struct ContactBatch {
  int count = 0;
  int longest_group = 0;  // contacts

  // Gathered
  std::array<int, kBatchRows> candidate, group;  // in the contact list
  std::array<int, kBatchRows> was_touching;      // 1 or 0; at the last step
  std::array<int, kBatchRows> pair;              // index into the pair materials
  VectorColumn<D> apart;            // m; between the centres of the two spheres (not with walls)
  ScalarColumn distance_squared;    // m2 (not with walls)
  ScalarColumn reach;               // m; sum of the radii
  ScalarColumn stiffness_factor;    // N/m^1.5; 2 E* sqrt(R*)
  VectorColumn<D> offset;           // m; centre of the first body minus that of the second
  VectorColumn<D> arm;              // m; from the first body's centre to its sphere
  ScalarColumn radius;              // m; of that sphere
  RelativeMotionColumns<D> moved;   // half a step back: stretches the springs
  RelativeMotionColumns<D> moving;  // now: drives the dashpots
  ScalarColumn slip_time;           // s; how long `moved` has acted on this contact
  ScalarColumn reduced_mass;        // kg
  TangentColumn<D> spring;          // m

  // Geometry of the contact
  ScalarColumn overlap;                          // m
  VectorColumn<D> normal;                        // unit, from first to second
  ScalarColumn stiffness;                        // N/m; tangent
  ScalarColumn sum_of_stiffness, contact_count;  // of the group

  // What the law gives; `spring` is advanced
  ScalarColumn normal_force;          // N
  TangentColumn<D> tangential_force;  // N
  ScalarColumn slides;                // 1 or 0
  ScalarColumn normal_speed;          // m/s
  TangentColumn<D> tangential_speed;  // m/s
  VectorColumn<D> force;              // N, on the second body
  TangentColumn<D> moment;            // N m; of it about the first body's centre
  TangentColumn<D> second_moment;     // N m; about the second's (not with walls)
};

}  // namespace graintruth::sim
