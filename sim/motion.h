// What differs between one layer and three dimensions: vectors, spins and tangential springs. The
// rest of the simulation is written once, for both.
#pragma once

#include <cmath>

#include "sim/types.h"

namespace graintruth::sim {

template <int D>
using Vec = Eigen::Matrix<double, D, 1>;

// Planar: vectors are (x, z), a spin is one number in the picture sense (+x towards +z), and so is
// a tangential spring, along the normal turned by a quarter in that sense. Spatial: all three are
// vectors.
template <int D>
struct Motion;

template <>
struct Motion<2> {
  using Spin = double;
  using Tangent = double;
  static constexpr Spin no_spin() { return 0.0; }
  static constexpr Tangent no_tangent() { return 0.0; }
};

template <>
struct Motion<3> {
  using Spin = Vec3;
  using Tangent = Vec3;
  static Spin no_spin() { return Vec3::Zero(); }
  static Tangent no_tangent() { return Vec3::Zero(); }
};

// Velocity of a point at `lever` from the centre of a body that spins: w x l.
inline Vec2 spin_velocity(double spin, const Vec2& lever) {
  return {-spin * lever.y(), spin * lever.x()};
}
inline Vec3 spin_velocity(const Vec3& spin, const Vec3& lever) { return spin.cross(lever); }

// Moment of a force about the centre: l x f (thesis 2.6; the product of 1.61 is in the wrong
// order).
inline double moment(const Vec2& lever, const Vec2& force) {
  return lever.x() * force.y() - lever.y() * force.x();
}
inline Vec3 moment(const Vec3& lever, const Vec3& force) { return lever.cross(force); }

// Part of `velocity` in the tangent plane (thesis 1.45-1.46); `along_normal` is its part along the
// unit normal.
inline double tangential_part(const Vec2& velocity, const Vec2& normal, double) {
  return normal.x() * velocity.y() - normal.y() * velocity.x();
}
inline Vec3 tangential_part(const Vec3& velocity, const Vec3& normal, double along_normal) {
  return velocity - along_normal * normal;
}

// A tangential quantity as a vector.
inline Vec2 as_vector(double tangent, const Vec2& normal) {
  return {-tangent * normal.y(), tangent * normal.x()};
}
inline Vec3 as_vector(const Vec3& tangent, const Vec3&) { return tangent; }

// The spring turned into the new tangent plane, its length kept. In the plane it turns with the
// normal by itself.
inline double turned_into_plane(double spring, const Vec2&) { return spring; }
inline Vec3 turned_into_plane(const Vec3& spring, const Vec3& normal) {
  const Vec3 flat = spring - spring.dot(normal) * normal;
  const double squared = flat.squaredNorm();
  return squared > 0.0 ? Vec3(flat * std::sqrt(spring.squaredNorm() / squared)) : flat;
}

inline double length_of(double tangent) { return std::abs(tangent); }
inline double length_of(const Vec3& tangent) { return tangent.norm(); }
inline double product_of(double a, double b) { return a * b; }
inline double product_of(const Vec3& a, const Vec3& b) { return a.dot(b); }

// Between the layer and space.
template <int D>
inline Vec<D> to_motion(const Vec3& v) {
  if constexpr (D == 2) {
    return into_plane(v);
  } else {
    return v;
  }
}
template <int D>
inline typename Motion<D>::Spin to_spin(const Vec3& angular_velocity) {
  if constexpr (D == 2) {
    return picture_spin_of(angular_velocity);
  } else {
    return angular_velocity;
  }
}
inline Vec3 to_space(const Vec2& v, double layer = 0.0) { return {v.x(), layer, v.y()}; }
inline Vec3 to_space(const Vec3& v, double = 0.0) { return v; }

// sin and cos of the small turn of one step. Taylor series: below 0.1 rad exact to round-off,
// without the library functions, whose last bit differs from machine to machine.
struct SmallTurn {
  double sine, cosine;
};

inline SmallTurn small_turn(double angle) {
  if (std::abs(angle) > 0.1) return {std::sin(angle), std::cos(angle)};
  // Coefficients 1/n!, multiplied rather than divided: a division takes as long as four products
  constexpr double c2 = 1.0 / 2, c3 = 1.0 / 6, c4 = 1.0 / 24, c5 = 1.0 / 120, c6 = 1.0 / 720;
  constexpr double c7 = 1.0 / 5040, c8 = 1.0 / 40320, c9 = 1.0 / 362880, c10 = 1.0 / 3628800;
  const double s = angle * angle;
  return {angle * (1.0 - s * (c3 - s * (c5 - s * (c7 - s * c9)))),
          1.0 - s * (c2 - s * (c4 - s * (c6 - s * (c8 - s * c10))))};
}

}  // namespace graintruth::sim
