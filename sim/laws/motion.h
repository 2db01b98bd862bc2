// What differs between one layer and three dimensions: vectors, spins and tangential springs. The
// rest of the simulation is written once, for both.
#pragma once

#include <cmath>

#include "sim/types.h"

namespace graintruth::sim {

template <int D>
using Vec = Eigen::Matrix<double, D, 1>;

// Vectors of plain numbers for the contact loops: compilers run several contacts at once through
// them, which the ready-made packets of Eigen's small vectors would prevent.
struct PlanarVector {
  double x, z;
};
struct SpatialVector {
  double x, y, z;
};

inline PlanarVector operator+(PlanarVector a, PlanarVector b) { return {a.x + b.x, a.z + b.z}; }
inline PlanarVector operator-(PlanarVector a, PlanarVector b) { return {a.x - b.x, a.z - b.z}; }
inline PlanarVector operator*(double s, PlanarVector a) { return {s * a.x, s * a.z}; }
inline double dot(PlanarVector a, PlanarVector b) { return a.x * b.x + a.z * b.z; }

inline SpatialVector operator+(SpatialVector a, SpatialVector b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline SpatialVector operator-(SpatialVector a, SpatialVector b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline SpatialVector operator*(double s, SpatialVector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(SpatialVector a, SpatialVector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline SpatialVector cross(SpatialVector a, SpatialVector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Planar: vectors are (x, z), a spin is one number in the picture sense (+x towards +z), and so is
// a tangential spring, along the normal turned by a quarter in that sense. Spatial: all three are
// vectors. `Vector` and `Tangent` are those of the contact loops, `Vec` and `Spin` of the bodies.
template <int D>
struct Motion;

template <>
struct Motion<2> {
  using Vector = PlanarVector;
  using Spin = double;
  using Tangent = double;  // also a spin in the contact loops
  static constexpr Spin no_spin() { return 0.0; }
  static constexpr Tangent no_tangent() { return 0.0; }
  static constexpr Vector no_vector() { return {0.0, 0.0}; }
};

template <>
struct Motion<3> {
  using Vector = SpatialVector;
  using Spin = Vec3;
  using Tangent = SpatialVector;
  static Spin no_spin() { return Vec3::Zero(); }
  static constexpr Tangent no_tangent() { return {0.0, 0.0, 0.0}; }
  static constexpr Vector no_vector() { return {0.0, 0.0, 0.0}; }
};

inline PlanarVector plain(const Vec2& v) { return {v.x(), v.y()}; }
inline SpatialVector plain(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline double plain(double v) { return v; }
inline PlanarVector plain(PlanarVector v) { return v; }
inline SpatialVector plain(SpatialVector v) { return v; }
inline Vec2 to_eigen(PlanarVector v) { return {v.x, v.z}; }
inline Vec3 to_eigen(SpatialVector v) { return {v.x, v.y, v.z}; }
inline double to_eigen(double v) { return v; }

// Velocity of a point at `lever` from the centre of a body that spins: w x l.
inline PlanarVector spin_velocity(double spin, PlanarVector lever) {
  return {-spin * lever.z, spin * lever.x};
}
inline SpatialVector spin_velocity(SpatialVector spin, SpatialVector lever) {
  return cross(spin, lever);
}

// Moment of a force about the centre: l x f (thesis 2.6; the product of 1.61 is in the wrong
// order).
inline double moment(PlanarVector lever, PlanarVector force) {
  return lever.x * force.z - lever.z * force.x;
}
inline SpatialVector moment(SpatialVector lever, SpatialVector force) {
  return cross(lever, force);
}

// Part of `velocity` in the tangent plane (thesis 1.45-1.46); `along_normal` is its part along the
// unit normal.
inline double tangential_part(PlanarVector velocity, PlanarVector normal, double) {
  return normal.x * velocity.z - normal.z * velocity.x;
}
inline SpatialVector tangential_part(SpatialVector velocity,
                                     SpatialVector normal,
                                     double along_normal) {
  return velocity - along_normal * normal;
}

// A tangential quantity as a vector.
inline PlanarVector as_vector(double tangent, PlanarVector normal) {
  return {-tangent * normal.z, tangent * normal.x};
}
inline SpatialVector as_vector(SpatialVector tangent, SpatialVector) { return tangent; }

// The spring turned into the new tangent plane, its length kept. In the plane it turns with the
// normal by itself.
inline double turned_into_plane(double spring, PlanarVector) { return spring; }
inline SpatialVector turned_into_plane(SpatialVector spring, SpatialVector normal) {
  const SpatialVector flat = spring - dot(spring, normal) * normal;
  constexpr double kNothing = 1e-200;  // m2; so that what has no length keeps none
  return std::sqrt(dot(spring, spring) / (dot(flat, flat) + kNothing)) * flat;
}

// A turning without its part about the normal. In the plane there is none.
inline double without_twist(double turning, PlanarVector) { return turning; }
inline SpatialVector without_twist(SpatialVector turning, SpatialVector normal) {
  return turning - dot(turning, normal) * normal;
}

inline double length_of(double tangent) { return std::abs(tangent); }
inline double length_of(SpatialVector tangent) { return std::sqrt(dot(tangent, tangent)); }
inline double product_of(double a, double b) { return a * b; }
inline double product_of(SpatialVector a, SpatialVector b) { return dot(a, b); }

inline double length_of_vector(PlanarVector v) { return std::sqrt(dot(v, v)); }
inline double length_of_vector(SpatialVector v) { return std::sqrt(dot(v, v)); }

// One or the other, without a branch.
inline double chosen(bool first, double a, double b) { return first ? a : b; }
inline SpatialVector chosen(bool first, SpatialVector a, SpatialVector b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

// A unit quaternion of plain numbers.
struct Rotation {
  double w, x, y, z;
};
inline Rotation operator*(Rotation a, Rotation b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
          a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}
inline Rotation operator*(double s, Rotation a) { return {s * a.w, s * a.x, s * a.y, s * a.z}; }
inline double product_of(Rotation a, Rotation b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}
inline double squared(Rotation a) { return a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z; }

//   R v = v + 2 w (u x v) + 2 u x (u x v),  u = (x, y, z)
inline SpatialVector turned_by(Rotation r, SpatialVector v) {
  const SpatialVector u{r.x, r.y, r.z};
  const SpatialVector twice = 2.0 * cross(u, v);
  return v + r.w * twice + cross(u, twice);
}
inline SpatialVector turned_back(Rotation r, SpatialVector v) {
  return turned_by({r.w, -r.x, -r.y, -r.z}, v);
}

inline Rotation plain(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Quat to_eigen(Rotation r) { return {r.w, r.x, r.y, r.z}; }

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

// Taylor series of the small turn of one step: below 0.2 rad exact to round-off, without the
// library functions, whose last bit differs from machine to machine. Coefficients 1/n!, multiplied
// rather than divided: a division takes as long as four products.
namespace taylor {
constexpr double c2 = 1.0 / 2, c3 = 1.0 / 6, c4 = 1.0 / 24, c5 = 1.0 / 120, c6 = 1.0 / 720;
constexpr double c7 = 1.0 / 5040, c8 = 1.0 / 40320, c9 = 1.0 / 362880, c10 = 1.0 / 3628800;
inline double sine_over_angle(double squared) {
  return 1.0 - squared * (c3 - squared * (c5 - squared * (c7 - squared * c9)));
}
inline double cosine(double squared) {
  return 1.0 - squared * (c2 - squared * (c4 - squared * (c6 - squared * (c8 - squared * c10))));
}
}  // namespace taylor

struct SmallTurn {
  double sine, cosine;
};
inline SmallTurn small_turn(double angle) {
  const double squared = angle * angle;
  return {angle * taylor::sine_over_angle(squared), taylor::cosine(squared)};
}

// Of half the turn of a step, from its square (rad2): no root is taken.
struct HalfTurn {
  double sine_over_angle, cosine;
};
inline HalfTurn half_turn(double squared) {
  return {taylor::sine_over_angle(squared), taylor::cosine(squared)};
}

}  // namespace graintruth::sim
