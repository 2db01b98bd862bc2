#include "sim/walls.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graintruth::sim {
namespace {

// Two ends closer than this share of the wall's length are one corner: measured rigs are given to
// 1e-9 m.
constexpr double kCornerTolerance = 1e-6;

Vec2 nearest_point(const Wall& wall, const Vec2& point) {
  return wall.from + nearest_share(wall, point) * (wall.to - wall.from);
}

}  // namespace

Wall segment_wall(const Vec2& from, const Vec2& to, const WallMotion& motion, int material) {
  if (!((to - from).norm() > 0.0)) {
    throw std::invalid_argument("segment_wall: both ends are the same point");
  }
  Wall wall;
  wall.shape = Wall::Shape::segment;
  wall.from = from;
  wall.to = to;
  wall.motion = motion;
  wall.material = material;
  return wall;
}

Wall plane_wall(const Vec3& point, const Vec3& normal, const WallMotion& motion, int material) {
  if (!(normal.norm() > 0.0)) throw std::invalid_argument("plane_wall: the normal has no length");
  Wall wall;
  wall.shape = Wall::Shape::plane;
  wall.point = point;
  wall.normal = normal.normalized();
  wall.motion = motion;
  wall.material = material;
  return wall;
}

bool edge_belongs_to_another(std::span<const Wall> walls, int wall, const Vec3& centre) {
  const Vec2 seen_from = into_plane(centre);
  const Vec2 corner = nearest_point(walls[wall], seen_from);
  const double corner_distance = (corner - seen_from).norm();
  for (int other = 0; other < static_cast<int>(walls.size()); ++other) {
    if (other == wall) continue;
    const Wall& candidate = walls[other];
    if (candidate.shape == Wall::Shape::plane) continue;
    const double tolerance = kCornerTolerance * (candidate.to - candidate.from).norm();
    if ((nearest_point(candidate, corner) - corner).norm() > tolerance) continue;
    const double distance = (nearest_point(candidate, seen_from) - seen_from).norm();
    const bool nearer = distance < corner_distance - tolerance;
    const bool as_near = distance < corner_distance + tolerance;
    const bool other_sees_face = !look_at(candidate, centre).is_edge;
    if (nearer || (as_near && (other_sees_face || other < wall))) return true;
  }
  return false;
}

void move_walls(std::span<const Wall> at_rest, double time, std::vector<Wall>& now) {
  now.assign(at_rest.begin(), at_rest.end());
  for (Wall& wall : now) {
    const Vec3 moved = displacement_of(wall, time);
    wall.from += into_plane(moved);
    wall.to += into_plane(moved);
    wall.point += moved;
  }
}

}  // namespace graintruth::sim
