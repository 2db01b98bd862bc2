#include "sim/shapes/walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace graintruth::sim {
namespace {

// Two rims closer than this share of the wall's length are one edge: measured rigs are given to
// 1e-9 m.
constexpr double kCornerTolerance = 1e-6;

// A foot closer to the rim of a polygon than this share of its side is seen at the rim, so that
// round-off never puts it inside both facets of a seam.
constexpr double kRimTolerance = 1e-12;

// How far, in sides, a corner may lie out of the plane of its polygon: files in single precision.
constexpr double kFlatTolerance = 1e-5;

void require(bool fulfilled, const std::string& sentence) {
  if (!fulfilled) throw std::invalid_argument(sentence);
}

struct NearestPoint {
  Vec3 point;
  bool is_edge = false;
};

Vec3 nearest_on_line(const Vec3& from, const Vec3& to, const Vec3& point) {
  const Vec3 along = to - from;
  const double share = (point - from).dot(along) / along.squaredNorm();
  return from + std::clamp(share, 0.0, 1.0) * along;
}

// The foot of the perpendicular when it lies inside all sides, else the nearest point of the rim.
NearestPoint nearest_on_polygon(const Wall& wall, const Vec3& point) {
  const std::size_t count = wall.corners.size();
  const Vec3 foot = point - (point - wall.corners[0]).dot(wall.normal) * wall.normal;
  bool inside = true, clearly_inside = true;
  Vec3 nearest = wall.corners[0];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& from = wall.corners[i];
    const Vec3& to = wall.corners[i + 1 < count ? i + 1 : 0];
    const Vec3 along = to - from;
    const double inwards = wall.normal.cross(along).dot(foot - from);  // m2: side times distance
    inside = inside && inwards >= 0.0;
    clearly_inside = clearly_inside && inwards > kRimTolerance * along.squaredNorm();
    const Vec3 candidate = nearest_on_line(from, to, foot);
    const double squared = (candidate - foot).squaredNorm();
    if (squared < least) {
      least = squared;
      nearest = candidate;
    }
  }
  return {inside ? foot : nearest, !clearly_inside};
}

NearestPoint nearest_on_disk(const Wall& wall, const Vec3& point) {
  const Vec3 apart = point - wall.point;
  const Vec3 in_plane = apart - apart.dot(wall.normal) * wall.normal;
  const double out = in_plane.norm();
  if (out < wall.radius) return {wall.point + in_plane, false};
  return {wall.point + (wall.radius / out) * in_plane, true};
}

NearestPoint nearest_on_cylinder(const Wall& wall, const Vec3& point) {
  const Vec3 apart = point - wall.point;
  const double along = apart.dot(wall.normal);
  const Vec3 across = apart - along * wall.normal;
  const double out = across.norm();
  const Vec3 outwards = out > 0.0 ? Vec3(across / out) : wall.normal.unitOrthogonal();
  return {wall.point + std::clamp(along, 0.0, wall.length) * wall.normal + wall.radius * outwards,
          along <= 0.0 || along >= wall.length};
}

NearestPoint nearest_point(const Wall& wall, const Vec3& point) {
  switch (wall.shape) {
    case Wall::Shape::polygon:
      return nearest_on_polygon(wall, point);
    case Wall::Shape::disk:
      return nearest_on_disk(wall, point);
    case Wall::Shape::cylinder:
      return nearest_on_cylinder(wall, point);
    case Wall::Shape::segment: {
      const double share = nearest_share(wall, into_plane(point));
      const Vec2 nearest = wall.from + share * (wall.to - wall.from);
      return {Vec3(nearest.x(), point.y(), nearest.y()), share == 0.0 || share == 1.0};
    }
    case Wall::Shape::plane:
    case Wall::Shape::none:
      break;
  }
  return {point - (point - wall.point).dot(wall.normal) * wall.normal, false};
}

// A length of the wall, m, for tolerances.
double scale_of(const Wall& wall) {
  if (wall.shape == Wall::Shape::segment) return (wall.to - wall.from).norm();
  if (wall.shape == Wall::Shape::polygon) return (wall.corners[1] - wall.corners[0]).norm();
  return wall.radius;
}

// How long a motion has gone on at `time`, s.
double moving_time(const WallMotion& motion, double time) {
  return std::max(std::min(time, motion.end_time) - motion.start_time, 0.0);
}

void add_twist(const WallMotion& motion, double time, Twist& sum) {
  if (!(time > motion.start_time && time <= motion.end_time)) return;
  sum.velocity += motion.velocity;
  if (motion.angular_velocity.isZero(0.0)) return;
  // v(p) = V + w x (p - pivot)
  const Vec3 pivot = motion.pivot + moving_time(motion, time) * motion.velocity;
  sum.velocity -= motion.angular_velocity.cross(pivot);
  sum.spin += motion.angular_velocity;
}

// Visits the points whose motion bounds that of the whole wall, and whose box, widened by the
// radius, holds it.
template <class Visitor>
void visit_outline(const Wall& wall, Visitor visit) {
  if (wall.shape == Wall::Shape::polygon) {
    for (const Vec3& corner : wall.corners) visit(corner);
  } else if (wall.shape == Wall::Shape::segment) {
    visit(Vec3(wall.from.x(), 0.0, wall.from.y()));
    visit(Vec3(wall.to.x(), 0.0, wall.to.y()));
  } else {
    visit(wall.point);
    if (wall.shape == Wall::Shape::cylinder) visit(wall.point + wall.length * wall.normal);
  }
}

}  // namespace

Wall segment_wall(const Vec2& from, const Vec2& to, const WallMotion& motion, int material) {
  require((to - from).norm() > 0.0, "segment_wall: both ends are the same point");
  Wall wall;
  wall.shape = Wall::Shape::segment;
  wall.from = from;
  wall.to = to;
  wall.motion = motion;
  wall.material = material;
  return wall;
}

Wall plane_wall(const Vec3& point, const Vec3& normal, const WallMotion& motion, int material) {
  require(normal.norm() > 0.0, "plane_wall: the normal has no length");
  Wall wall;
  wall.shape = Wall::Shape::plane;
  wall.point = point;
  wall.normal = normal.normalized();
  wall.motion = motion;
  wall.material = material;
  return wall;
}

Wall polygon_wall(std::vector<Vec3> corners, const WallMotion& motion, int material) {
  const std::size_t count = corners.size();
  require(count >= 3, "polygon_wall: a polygon needs at least three corners");
  // Twice the area as a vector: sum of p_i x p_(i+1) about the first corner
  Vec3 area = Vec3::Zero();
  double side = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& next = corners[i + 1 < count ? i + 1 : 0];
    area += (corners[i] - corners[0]).cross(next - corners[0]);
    side = std::max(side, (next - corners[i]).norm());
  }
  require(area.norm() > kRimTolerance * side * side, "polygon_wall: the corners enclose no area");
  Wall wall;
  wall.shape = Wall::Shape::polygon;
  wall.normal = area.normalized();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& from = corners[i];
    const Vec3& to = corners[(i + 1) % count];
    const Vec3& after = corners[(i + 2) % count];
    require(std::abs((from - corners[0]).dot(wall.normal)) <= kFlatTolerance * side,
            "polygon_wall: the corners do not lie in one plane");
    require((to - from).norm() > 0.0, "polygon_wall: two corners are the same point");
    require((to - from).cross(after - to).dot(wall.normal) >= -kFlatTolerance * side * side,
            "polygon_wall: the corners are not convex");
  }
  wall.point = corners[0];
  wall.corners = std::move(corners);
  wall.motion = motion;
  wall.material = material;
  return wall;
}

Wall disk_wall(
    const Vec3& centre, const Vec3& normal, double radius, const WallMotion& motion, int material) {
  require(radius > 0.0, "disk_wall: the radius must be above 0");
  Wall wall = plane_wall(centre, normal, motion, material);
  wall.shape = Wall::Shape::disk;
  wall.radius = radius;
  return wall;
}

Wall cylinder_wall(
    const Vec3& from, const Vec3& to, double radius, const WallMotion& motion, int material) {
  require((to - from).norm() > 0.0, "cylinder_wall: both ends are the same point");
  require(radius > 0.0, "cylinder_wall: the radius must be above 0");
  Wall wall = plane_wall(from, to - from, motion, material);
  wall.shape = Wall::Shape::cylinder;
  wall.radius = radius;
  wall.length = (to - from).norm();
  return wall;
}

MeshWalls mesh_walls(std::span<const Vec3> corners,
                     int body,
                     const WallMotion& motion,
                     int material) {
  require(corners.size() % 3 == 0, "mesh_walls: a facet has three corners");
  require(body >= 0, "mesh_walls: the number of the body must not be below 0");
  using Corner = std::array<double, 3>;
  std::set<std::array<Corner, 3>> seen;
  MeshWalls mesh;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    std::array<Corner, 3> facet;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& corner = corners[i + k];
      facet[k] = {corner.x(), corner.y(), corner.z()};
    }
    std::sort(facet.begin(), facet.end());
    if (!seen.insert(facet).second) {
      ++mesh.merged;
      continue;
    }
    mesh.facets.push_back(
        polygon_wall({corners[i], corners[i + 1], corners[i + 2]}, motion, material));
    mesh.facets.back().body = body;
  }
  return mesh;
}

WallBodies bodies_of_walls(std::span<const Wall> walls) {
  const int count = static_cast<int>(walls.size());
  WallBodies bodies;
  bodies.of_wall.resize(walls.size());
  std::map<int, int> first_of_body;
  for (int w = 0; w < count; ++w) {
    bodies.of_wall[w] = w;
    if (walls[w].body < 0) continue;
    bodies.of_wall[w] = first_of_body.try_emplace(walls[w].body, w).first->second;
    if (bodies.of_wall[w] != w) bodies.are_all_alone = false;
  }
  bodies.order.resize(walls.size());
  std::iota(bodies.order.begin(), bodies.order.end(), 0);
  std::stable_sort(bodies.order.begin(), bodies.order.end(), [&](int a, int b) {
    return bodies.of_wall[a] < bodies.of_wall[b];
  });
  bodies.rank.resize(walls.size());
  for (int place = 0; place < count; ++place) bodies.rank[bodies.order[place]] = place;
  return bodies;
}

Twist surface_twist(const Wall& wall, double time) {
  Twist twist;
  add_twist(wall.motion, time, twist);
  add_twist(wall.drag, time, twist);
  return twist;
}

double fastest_point(const Wall& wall) {
  const WallMotion& motion = wall.motion;
  double farthest = 0.0;  // m; from the axis
  const double turning = motion.angular_velocity.norm();
  if (turning > 0.0) {
    const Vec3 axis = motion.angular_velocity / turning;
    visit_outline(wall, [&](const Vec3& point) {
      farthest = std::max(farthest, axis.cross(point - motion.pivot).norm() + wall.radius);
    });
  }
  return motion.velocity.norm() + turning * farthest;
}

void place_wall(const Wall& at_rest, double time, Wall& now) {
  const WallMotion& motion = at_rest.motion;
  const double duration = moving_time(motion, time);
  const Vec3 moved = duration * motion.velocity;
  now.shape = time >= at_rest.opens_at ? Wall::Shape::none : at_rest.shape;
  if (motion.angular_velocity.isZero(0.0)) {
    now.from = at_rest.from + into_plane(moved);
    now.to = at_rest.to + into_plane(moved);
    now.point = at_rest.point + moved;
    for (std::size_t i = 0; i < now.corners.size(); ++i) {
      now.corners[i] = at_rest.corners[i] + moved;
    }
    return;
  }
  const double turning = motion.angular_velocity.norm();
  const Mat3 turn =
      turn_about(motion.angular_velocity / turning, turning * duration).toRotationMatrix();
  const auto place = [&](const Vec3& point) -> Vec3 {
    return motion.pivot + moved + turn * (point - motion.pivot);
  };
  now.from = into_plane(place(Vec3(at_rest.from.x(), 0.0, at_rest.from.y())));
  now.to = into_plane(place(Vec3(at_rest.to.x(), 0.0, at_rest.to.y())));
  now.point = place(at_rest.point);
  now.normal = turn * at_rest.normal;
  for (std::size_t i = 0; i < now.corners.size(); ++i) now.corners[i] = place(at_rest.corners[i]);
}

WallView look_at_shape(const Wall& wall, const Vec3& point) {
  if (wall.shape == Wall::Shape::none) {
    return {Vec3::UnitZ(), std::numeric_limits<double>::infinity(), false};
  }
  const NearestPoint nearest = nearest_point(wall, point);
  const Vec3 apart = nearest.point - point;
  const double distance = apart.norm();
  return {apart * (1.0 / distance), distance, nearest.is_edge};
}

bool edge_belongs_to(const Wall& other,
                     bool other_comes_first,
                     const Wall& wall,
                     const Vec3& centre) {
  if (other.shape == Wall::Shape::plane || other.shape == Wall::Shape::none) return false;
  const Vec3 seen = nearest_point(wall, centre).point;
  const double tolerance = kCornerTolerance * scale_of(other);
  if ((nearest_point(other, seen).point - seen).norm() > tolerance) return false;
  const NearestPoint of_other = nearest_point(other, centre);
  // The very same point: compared by index, so that round-off never hands a contact to and fro
  if ((of_other.point - seen).norm() <= tolerance) return !of_other.is_edge || other_comes_first;
  return (of_other.point - centre).squaredNorm() < (seen - centre).squaredNorm();
}

void move_walls(std::span<const Wall> at_rest, double time, std::vector<Wall>& now) {
  now.assign(at_rest.begin(), at_rest.end());
  for (std::size_t w = 0; w < at_rest.size(); ++w) place_wall(at_rest[w], time, now[w]);
}

Box box_of(const Wall& wall) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Box box{Vec3::Constant(-kNone), Vec3::Constant(kNone)};
  if (wall.shape == Wall::Shape::plane || wall.shape == Wall::Shape::none) return box;
  box = {box.high, box.low};
  visit_outline(wall, [&](const Vec3& point) {
    box.low = box.low.cwiseMin(point);
    box.high = box.high.cwiseMax(point);
  });
  box.low.array() -= wall.radius;
  box.high.array() += wall.radius;
  if (wall.shape == Wall::Shape::segment) {
    box.low.y() = -kNone;
    box.high.y() = kNone;
  }
  return box;
}

}  // namespace graintruth::sim
