#include "sim/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

void require(bool fulfilled, const std::string& sentence) {
  if (!fulfilled) throw std::invalid_argument("Scene: " + sentence);
}

// How far, in radii, a sphere of a planar scene may lie out of the layer: round-off of an
// orientation.
constexpr double kLayerTolerance = 1e-9;

void check_wall(const Wall& wall, const std::string& name, bool planar) {
  using Shape = Wall::Shape;
  for (const WallMotion* motion : {&wall.motion, &wall.drag}) {
    require(motion->velocity.allFinite() && motion->angular_velocity.allFinite() &&
                motion->pivot.allFinite(),
            name + " has a velocity that is not finite");
    require(motion->angular_velocity.isZero(0.0) || !planar ||
                motion->angular_velocity.cross(Vec3::UnitY()).isZero(0.0),
            name + " turns out of the layer of a planar scene");
  }
  const Vec3& turning = wall.motion.angular_velocity;
  require(wall.shape != Shape::plane ||
              turning.cross(wall.normal).norm() <= kLayerTolerance * turning.norm(),
          name + " is a plane without bounds and can turn about its normal only");
  if (!planar || wall.shape == Shape::segment || wall.shape == Shape::none) return;
  const bool across = wall.shape == Shape::cylinder ? wall.normal.cross(Vec3::UnitY()).isZero(0.0)
                                                    : wall.normal.y() == 0.0;
  require(across && (wall.shape == Shape::plane || wall.shape == Shape::cylinder),
          name +
              " does not stand upright on the layer of a planar scene: a segment, a plane or a "
              "cylinder along y can");
}

void check_period(const Scene& scene) {
  const Period& period = scene.period;
  require(period.low.allFinite() && period.length.allFinite() && period.length.minCoeff() >= 0.0,
          "the period must be finite and not negative");
  require(!scene.planar || period.length.y() == 0.0, "one layer does not repeat along y");
  double longest = 0.0;
  for (const Body& body : scene.bodies)
    longest = std::max(longest, 2.0 * scene.types[body.type].bounding_radius);
  for (int axis = 0; axis < 3; ++axis) {
    const double length = period.length[axis];
    require(length == 0.0 || length >= 2.0 * longest,
            std::string("the period along ") + "xyz"[axis] + " is " + std::to_string(length) +
                " m, but must be at least two lengths of the largest body, " +
                std::to_string(2.0 * longest) + " m");
  }
}

}  // namespace

double picture_angle_of(const Quat& world_from_body) {
  const Vec3 axis = world_from_body * Vec3::UnitX();
  return steady_atan2(axis.z(), axis.x());
}

Quat turn_about(const Vec3& axis, double angle) {
  const auto [sine, cosine] = steady_sine_and_cosine(0.5 * angle);
  return {cosine, sine * axis.x(), sine * axis.y(), sine * axis.z()};
}

Quat orientation_from_picture_angle(double angle) { return turn_about(Vec3::UnitY(), -angle); }

const Surfaces& SurfaceTable::of(int first, int second) const {
  static const Surfaces unset;
  const int low = std::min(first, second), high = std::max(first, second);
  for (const Entry& entry : entries_) {
    if (entry.low == low && entry.high == high) return entry.surfaces;
  }
  return unset;
}

void SurfaceTable::set(int first, int second, const Surfaces& surfaces) {
  check(surfaces);
  const int low = std::min(first, second), high = std::max(first, second);
  for (Entry& entry : entries_) {
    if (entry.low == low && entry.high == high) {
      entry.surfaces = surfaces;
      return;
    }
  }
  entries_.push_back({low, high, surfaces});
}

int Scene::add_material(const Material& material) {
  check(material);
  materials.push_back(material);
  return static_cast<int>(materials.size()) - 1;
}

int Scene::add_type(Clump clump) {
  types.push_back(std::move(clump));
  return static_cast<int>(types.size()) - 1;
}

int Scene::add_body(int type,
                    const Vec3& position,
                    const Quat& orientation,
                    const Vec3& velocity,
                    const Vec3& angular_velocity) {
  bodies.push_back({type,
                    position,
                    orientation.normalized(),
                    velocity,
                    angular_velocity,
                    planar ? picture_angle_of(orientation) : 0.0});
  return static_cast<int>(bodies.size()) - 1;
}

int Scene::add_planar_body(int type,
                           const Vec2& position,
                           double picture_angle,
                           const Vec2& velocity,
                           double picture_spin) {
  bodies.push_back({type,
                    Vec3(position.x(), 0.0, position.y()),
                    orientation_from_picture_angle(picture_angle),
                    Vec3(velocity.x(), 0.0, velocity.y()),
                    angular_velocity_from_picture_spin(picture_spin),
                    picture_angle});
  return static_cast<int>(bodies.size()) - 1;
}

int Scene::add_wall(const Wall& wall) {
  walls.push_back(wall);
  return static_cast<int>(walls.size()) - 1;
}

int Scene::next_wall_body() const {
  int next = 0;
  for (const Wall& wall : walls) next = std::max(next, wall.body + 1);
  return next;
}

void check(const Scene& scene) {
  const int materials = static_cast<int>(scene.materials.size());
  for (const Material& material : scene.materials) check(material);
  require(scene.gravity.allFinite(), "gravity must be finite");
  for (std::size_t i = 0; i < scene.types.size(); ++i) {
    const Clump& type = scene.types[i];
    const std::string name = "type " + std::to_string(i);
    require(type.material >= 0 && type.material < materials, name + " names an unknown material");
    require(!type.spheres.empty(), name + " has no spheres");
    for (const ElementSphere& sphere : type.spheres) {
      require(!scene.planar || std::abs(sphere.centre.y()) <= kLayerTolerance * sphere.radius,
              name + " has a sphere out of the layer (y = 0 in the body frame)");
    }
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    const Wall& wall = scene.walls[i];
    const std::string name = "wall " + std::to_string(i);
    require(wall.material >= 0 && wall.material < materials, name + " names an unknown material");
    check_wall(wall, name, scene.planar);
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const std::string name = "body " + std::to_string(i);
    require(body.type >= 0 && body.type < static_cast<int>(scene.types.size()),
            name + " names an unknown type");
    require(body.position.allFinite() && body.orientation.coeffs().allFinite() &&
                body.velocity.allFinite() && body.angular_velocity.allFinite(),
            name + " has a value that is not finite");
    if (!scene.planar) continue;
    require(body.position.y() == scene.bodies.front().position.y(),
            name + " lies in another layer than body 0");
    require((body.orientation * Vec3::UnitY() - Vec3::UnitY()).norm() < kLayerTolerance,
            name + " is tilted out of the layer");
  }
  check_period(scene);
}

}  // namespace graintruth::sim
