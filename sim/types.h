// Vectors, rotations and the one place where the sense of a planar angle is fixed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace graintruth::sim {

using Vec2 = Eigen::Vector2d;  // planar scenes: (x, z)
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

// Without y.
inline Vec2 into_plane(const Vec3& v) { return {v.x(), v.z()}; }

// Axes are right-handed with x to the right and z up, so y points away from the viewer. A picture
// angle turns +x towards +z (counter-clockwise as seen): it is MINUS the right-handed rotation
// about +y. Everything outside this library speaks of picture angles; everything three-dimensional
// inside of right-handed spins.

// Orientation whose body x axis lies at `angle` (rad, picture sense) in the x-z plane.
Quat orientation_from_picture_angle(double angle);

// A right-handed turn by `angle` (rad) about a unit axis.
Quat turn_about(const Vec3& axis, double angle);

// Picture angle of the body x axis, rad in (-pi, pi].
double picture_angle_of(const Quat& world_from_body);

// Right-handed angular velocity vector of a planar spin (rad/s, positive from +x towards +z).
inline Vec3 angular_velocity_from_picture_spin(double spin) { return {0.0, -spin, 0.0}; }
inline double picture_spin_of(const Vec3& angular_velocity) { return -angular_velocity.y(); }

}  // namespace graintruth::sim
