// Scene: what a simulation starts from. Plain data in SI units; the simulation never changes it.
#pragma once

#include <optional>
#include <vector>

#include "sim/laws/material.h"
#include "sim/shapes/clump.h"
#include "sim/shapes/walls.h"
#include "sim/types.h"

namespace graintruth::sim {

// Surfaces of every pair of materials; symmetric. Pairs that were never set have no friction and
// restitution 1.
class SurfaceTable {
 public:
  const Surfaces& of(int first, int second) const;
  void set(int first, int second, const Surfaces& surfaces);

 private:
  struct Entry {
    int low, high;
    Surfaces surfaces;
  };
  std::vector<Entry> entries_;
};

// One clump placed in the scene.
struct Body {
  int type = 0;                          // index into Scene::types
  Vec3 position = Vec3::Zero();          // m; centre of mass
  Quat orientation = Quat::Identity();   // world from body
  Vec3 velocity = Vec3::Zero();          // m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, right-handed, world axes
  double picture_angle = 0.0;            // rad, unwrapped; planar scenes only, see types.h
};

// Where a scene repeats itself: what leaves it at low + length comes back at low, and touches what
// is there. Two lengths of the largest body must fit between. Walls are not repeated: one that
// reaches a side of the cell must go on behind it, by a radius of the largest body.
struct Period {
  Vec3 low = Vec3::Zero();     // m
  Vec3 length = Vec3::Zero();  // m; 0 along an axis that does not repeat
};

struct Scene {
  bool planar = false;                   // one layer: y fixed, rotation about y only
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  // m/s2
  std::vector<Material> materials;
  SurfaceTable surfaces;
  std::vector<Clump> types;
  std::vector<Body> bodies;
  std::vector<Wall> walls;
  Period period;

  // Each returns the index of what was added.
  int add_material(const Material& material);
  int add_type(Clump clump);
  int add_body(int type,
               const Vec3& position,
               const Quat& orientation = Quat::Identity(),
               const Vec3& velocity = Vec3::Zero(),
               const Vec3& angular_velocity = Vec3::Zero());
  // Planar scenes: position and velocity in (x, z), angle and spin in the picture sense. The angle
  // is kept as given, so that a track that has turned more than once stays unwrapped.
  int add_planar_body(int type,
                      const Vec2& position,
                      double picture_angle,
                      const Vec2& velocity = Vec2::Zero(),
                      double picture_spin = 0.0);
  int add_wall(const Wall& wall);
  // A number for Wall::body that no wall of the scene has.
  int next_wall_body() const;
};

// Throws std::invalid_argument naming the part and the rule it breaks: an index out of range, a
// value that is not finite, a planar scene whose bodies leave the layer, a period too short.
void check(const Scene& scene);

}  // namespace graintruth::sim
