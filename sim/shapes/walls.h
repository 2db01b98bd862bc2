// Rigid walls: patches that stand on a segment of the x-z plane, infinite planes, flat polygons and
// disks in space, cylinders. They may move, turn, drag with their surface alone, and open.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sim/types.h"

namespace graintruth::sim {

// Constant velocity (m/s) and turning (rad/s, right-handed, about an axis through `pivot`, which
// goes along) from a start time (s) to an end time; at rest before and after.
struct WallMotion {
  Vec3 velocity = Vec3::Zero();
  double start_time = 0.0;
  double end_time = std::numeric_limits<double>::infinity();
  Vec3 angular_velocity = Vec3::Zero();
  Vec3 pivot = Vec3::Zero();  // m; a point of the axis at the start time

  bool is_none() const { return velocity.isZero(0.0) && angular_velocity.isZero(0.0); }
};

// All shapes but the plane have two solid faces. A triangle mesh is one polygon a facet, all of one
// body; edges and corners that walls share count once, see edge_belongs_to.
struct Wall {
  enum class Shape { segment, plane, polygon, disk, cylinder, none };
  Shape shape = Shape::plane;
  Vec2 from = Vec2::Zero();  // segment: ends in (x, z), m; reaches without end along y
  Vec2 to = Vec2::Zero();
  Vec3 point = Vec3::Zero();    // m; of a plane any, of a disk its centre, of a cylinder an end's
  Vec3 normal = Vec3::UnitZ();  // unit; of a plane towards the particles, of a cylinder its axis
  double radius = 0.0;          // m; disk, cylinder
  double length = 0.0;          // m; cylinder
  std::vector<Vec3> corners;    // m; polygon: convex, flat, in order
  WallMotion motion = {};       // of the wall itself
  WallMotion drag = {};         // of its surface alone, as a conveyor's: the wall stays
  double opens_at = std::numeric_limits<double>::infinity();  // s; from then on it is not there
  int material = 0;                                           // index into Scene::materials
  // Walls with the same number, from 0 on, are parts of one rigid body: a sphere that touches them
  // with one normal touches once, its spring goes with it from part to part, and its contacts with
  // them share the damping. Below zero: a body of its own.
  int body = -1;
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
// Throws std::invalid_argument with fewer than three corners, when they do not lie in one plane,
// enclose no area, or are not convex.
Wall polygon_wall(std::vector<Vec3> corners, const WallMotion& motion = {}, int material = 0);
// Throws std::invalid_argument when normal or radius is not above zero.
Wall disk_wall(const Vec3& centre,
               const Vec3& normal,
               double radius,
               const WallMotion& motion = {},
               int material = 0);
// The shell between the two end points, open at both. Contacts inside and outside are taken as on a
// flat wall: R* = R of the sphere.
// Throws std::invalid_argument when length or radius is not above zero.
Wall cylinder_wall(const Vec3& from,
                   const Vec3& to,
                   double radius,
                   const WallMotion& motion = {},
                   int material = 0);

// The facets of a triangle mesh as walls of one body, three corners a facet (m). `body` is a number
// that no other wall of the scene has, such as Scene::next_wall_body(). Facets with the same three
// corners, in either winding, are one.
// Throws std::invalid_argument when the number of corners is no multiple of three, `body` is below
// zero, or a facet encloses no area.
struct MeshWalls {
  std::vector<Wall> facets;
  int merged = 0;  // facets that stood in the mesh before
};
MeshWalls mesh_walls(std::span<const Vec3> corners,
                     int body,
                     const WallMotion& motion = {},
                     int material = 0);

// Which walls are of one body: that of each as the index of its first wall, and the walls in an
// order in which those of one body lie side by side.
struct WallBodies {
  std::vector<int> of_wall;
  std::vector<int> order;
  std::vector<int> rank;      // of each wall in that order
  bool are_all_alone = true;  // each wall is a body of its own
};
WallBodies bodies_of_walls(std::span<const Wall> walls);

// Velocity of the points of a rigid body: at p it is velocity + spin x p, m/s.
struct Twist {
  Vec3 velocity = Vec3::Zero();  // of the point at the origin
  Vec3 spin = Vec3::Zero();
};

// Of the surface of a wall, its drag included.
Twist surface_twist(const Wall& wall, double time);

// Whether a wall ever is elsewhere, drags, or opens.
inline bool is_still(const Wall& wall) {
  return wall.motion.is_none() && wall.drag.is_none() &&
         wall.opens_at == std::numeric_limits<double>::infinity();
}

// A bound on the speed of every point of a wall that moves, its drag left out, m/s.
double fastest_point(const Wall& wall);

// Puts `now` where the wall `at_rest` is at `time`; its shape is none when it has opened.
void place_wall(const Wall& at_rest, double time, Wall& now);

// Where a wall is seen from a point.
struct WallView {
  Vec3 direction;         // unit, from the point to the nearest point of the wall
  double distance = 0.0;  // m; below zero behind a plane
  bool is_edge = false;   // the nearest point is on the rim of the wall
};

// The wall as given, without its motion: move it first, or the point back.
WallView look_at(const Wall& wall, const Vec3& point);

// Nearest point of a segment to (x, z), as its share of the way from `from` to `to`.
inline double nearest_share(const Wall& wall, const Vec2& point) {
  const Vec2 along = wall.to - wall.from;
  const double share = (point - wall.from).dot(along) / along.squaredNorm();
  return share < 0.0 ? 0.0 : (share > 1.0 ? 1.0 : share);
}

// look_at for the shapes that are rare in planar scenes.
WallView look_at_shape(const Wall& wall, const Vec3& point);

inline WallView look_at(const Wall& wall, const Vec3& point) {
  if (wall.shape == Wall::Shape::plane) {
    return {-wall.normal, (point - wall.point).dot(wall.normal), false};
  }
  if (wall.shape != Wall::Shape::segment) return look_at_shape(wall, point);
  const Vec2 from_here = into_plane(point);
  const double share = nearest_share(wall, from_here);
  const Vec2 apart = wall.from + share * (wall.to - wall.from) - from_here;
  const double distance = apart.norm();
  const double inverse = 1.0 / distance;
  return {
      Vec3(apart.x() * inverse, 0.0, apart.y() * inverse), distance, share == 0.0 || share == 1.0};
}

// A rim that lies on another wall is an edge or a corner, and a sphere there must not be counted
// twice. The contact of `wall` seen at its rim from `centre` belongs to `other` when the seen point
// lies on it and it is nearer, or is seen at the same point with its face or with a lower index
// (`other_comes_first`). Both walls are where they are now.
bool edge_belongs_to(const Wall& other,
                     bool other_comes_first,
                     const Wall& wall,
                     const Vec3& centre);

// The walls at `time`.
void move_walls(std::span<const Wall> at_rest, double time, std::vector<Wall>& now);

// Smallest box around a wall, m; without bounds along the directions in which it has none.
struct Box {
  Vec3 low, high;
  // A lower bound of the distance from the box, m.
  double distance_bound(const Vec3& point) const {
    return (low - point).cwiseMax(point - high).maxCoeff();
  }
};
Box box_of(const Wall& wall);

}  // namespace graintruth::sim
