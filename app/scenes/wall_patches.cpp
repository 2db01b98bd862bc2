#include "app/scenes/wall_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace graintruth::app {

namespace {

using sim::Vec3;
using sim::Wall;

constexpr int round_parts = 48;

Vec3 on_circle(const Vec3& u, const Vec3& v, double radius, int part) {
  const double angle = 2.0 * std::numbers::pi * part / round_parts;
  return radius * (std::cos(angle) * u + std::sin(angle) * v);
}

// A plane clipped by the twelve edges of the box, its corners in order about their middle.
Patch clipped_plane(const Wall& wall, const sim::Box& box) {
  const auto corner = [&](int i) {
    return Vec3((i & 1) != 0 ? box.high.x() : box.low.x(),
                (i & 2) != 0 ? box.high.y() : box.low.y(),
                (i & 4) != 0 ? box.high.z() : box.low.z());
  };
  const double size = (box.high - box.low).norm();
  Patch patch;
  const auto add = [&](const Vec3& point) {
    for (const Vec3& other : patch) {
      if ((other - point).norm() < 1e-9 * size) return;
    }
    patch.push_back(point);
  };
  for (int i = 0; i < 8; ++i) {
    for (const int axis : {1, 2, 4}) {
      if ((i & axis) != 0) continue;
      const Vec3 from = corner(i), to = corner(i | axis);
      const double before = (from - wall.point).dot(wall.normal);
      const double after = (to - wall.point).dot(wall.normal);
      if (std::abs(before) < 1e-9 * size) add(from);
      if (std::abs(after) < 1e-9 * size) add(to);
      if (before * after < 0.0) add(from + before / (before - after) * (to - from));
    }
  }
  if (patch.size() < 3) return {};
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : patch) middle += point / static_cast<double>(patch.size());
  const Vec3 u = wall.normal.unitOrthogonal(), v = wall.normal.cross(u);
  const auto direction = [&](const Vec3& point) {
    return std::atan2((point - middle).dot(v), (point - middle).dot(u));
  };
  std::sort(patch.begin(), patch.end(), [&](const Vec3& a, const Vec3& b) {
    return direction(a) < direction(b);
  });
  return patch;
}

}  // namespace

std::vector<Patch> patches_of(const Wall& wall, const sim::Box& box) {
  const Vec3 u = wall.normal.unitOrthogonal(), v = wall.normal.cross(u);
  switch (wall.shape) {
    case Wall::Shape::segment:
      return {{Vec3(wall.from.x(), box.low.y(), wall.from.y()),
               Vec3(wall.to.x(), box.low.y(), wall.to.y()),
               Vec3(wall.to.x(), box.high.y(), wall.to.y()),
               Vec3(wall.from.x(), box.high.y(), wall.from.y())}};
    case Wall::Shape::polygon:
      return {wall.corners};
    case Wall::Shape::plane: {
      Patch patch = clipped_plane(wall, box);
      return patch.empty() ? std::vector<Patch>{} : std::vector<Patch>{std::move(patch)};
    }
    case Wall::Shape::disk: {
      Patch patch;
      for (int i = 0; i < round_parts; ++i) {
        patch.push_back(wall.point + on_circle(u, v, wall.radius, i));
      }
      return {patch};
    }
    case Wall::Shape::cylinder: {
      std::vector<Patch> strips;
      const Vec3 along = wall.length * wall.normal;
      for (int i = 0; i < round_parts; ++i) {
        const Vec3 from = wall.point + on_circle(u, v, wall.radius, i);
        const Vec3 to = wall.point + on_circle(u, v, wall.radius, i + 1);
        strips.push_back({from, to, to + along, from + along});
      }
      return strips;
    }
    case Wall::Shape::none:
      break;
  }
  return {};
}

sim::Box picture_box(const std::vector<Wall>& walls, const std::vector<Vec3>& points) {
  constexpr double none = std::numeric_limits<double>::infinity();
  sim::Box box{Vec3::Constant(none), Vec3::Constant(-none)};
  for (const Wall& wall : walls) {
    const sim::Box of_wall = sim::box_of(wall);
    for (int axis = 0; axis < 3; ++axis) {
      if (wall.shape == Wall::Shape::plane && std::abs(wall.normal[axis]) > 0.999) {
        box.low[axis] = std::min(box.low[axis], wall.point[axis]);
        box.high[axis] = std::max(box.high[axis], wall.point[axis]);
      }
      if (!std::isfinite(of_wall.low[axis]) || !std::isfinite(of_wall.high[axis])) continue;
      box.low[axis] = std::min(box.low[axis], of_wall.low[axis]);
      box.high[axis] = std::max(box.high[axis], of_wall.high[axis]);
    }
  }
  for (const Vec3& point : points) {
    box.low = box.low.cwiseMin(point);
    box.high = box.high.cwiseMax(point);
  }
  return box;
}

}  // namespace graintruth::app
