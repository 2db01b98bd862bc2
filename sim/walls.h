// Rigid walls: finite patches that stand on a segment of the x-z plane, and infinite planes; both
// may move.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sim/types.h"

namespace graintruth::sim {

// Constant velocity (m/s) from a start time (s) on; at rest before.
struct WallMotion {
  Vec3 velocity = Vec3::Zero();
  double start_time = 0.0;
};

struct Wall {
  enum class Shape { segment, plane };
  Shape shape = Shape::plane;
  Vec2 from =
      Vec2::Zero();  // segment: ends in (x, z), m; reaches without end along y; has two faces
  Vec2 to = Vec2::Zero();
  Vec3 point = Vec3::Zero();    // plane: a point on it, m
  Vec3 normal = Vec3::UnitZ();  // plane: unit, towards the particles
  WallMotion motion = {};
  int material = 0;  // index into Scene::materials
};

// Throws std::invalid_argument when both ends are the same point.
Wall segment_wall(const Vec2& from,
                  const Vec2& to,
                  const WallMotion& motion = {},
                  int material = 0);
// Throws std::invalid_argument when the normal has no length.
Wall plane_wall(const Vec3& point,
                const Vec3& normal,
                const WallMotion& motion = {},
                int material = 0);

// How far a wall has come by `time`, m.
inline Vec3 displacement_of(const Wall& wall, double time) {
  const double moving_time = time - wall.motion.start_time;
  return moving_time > 0.0 ? Vec3(moving_time * wall.motion.velocity) : Vec3(Vec3::Zero());
}

inline Vec3 velocity_of(const Wall& wall, double time) {
  return time > wall.motion.start_time ? wall.motion.velocity : Vec3(Vec3::Zero());
}

// Where a wall is seen from a point.
struct WallView {
  Vec3 direction;         // unit, from the point to the nearest point of the wall
  double distance = 0.0;  // m; below zero behind a plane
  bool is_edge = false;   // the nearest point is an end of the segment
};

// The wall as given, without its motion: move it first, or the point back.
WallView look_at(const Wall& wall, const Vec3& point);

// Nearest point of a segment to (x, z), as its share of the way from `from` to `to`.
inline double nearest_share(const Wall& wall, const Vec2& point) {
  const Vec2 along = wall.to - wall.from;
  const double share = (point - wall.from).dot(along) / along.squaredNorm();
  return share < 0.0 ? 0.0 : (share > 1.0 ? 1.0 : share);
}

inline WallView look_at(const Wall& wall, const Vec3& point) {
  if (wall.shape == Wall::Shape::plane) {
    return {-wall.normal, (point - wall.point).dot(wall.normal), false};
  }
  const Vec2 from_here = into_plane(point);
  const double share = nearest_share(wall, from_here);
  const Vec2 apart = wall.from + share * (wall.to - wall.from) - from_here;
  const double distance = apart.norm();
  const double inverse = 1.0 / distance;
  return {
      Vec3(apart.x() * inverse, 0.0, apart.y() * inverse), distance, share == 0.0 || share == 1.0};
}

// An end that lies on another wall is a corner, and a sphere there must not be counted twice. The
// contact of `wall` seen at an end belongs to the other wall when that one is nearer, or as near
// with a lower index. `walls` are where they are now.
bool edge_belongs_to_another(std::span<const Wall> walls, int wall, const Vec3& centre);

// The walls at `time`.
void move_walls(std::span<const Wall> at_rest, double time, std::vector<Wall>& now);

}  // namespace graintruth::sim
