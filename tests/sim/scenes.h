// Scenes that several tests and benchmarks start from.
#pragma once

#include <array>

#include "sim/relaxation.h"
#include "sim/scene.h"

namespace graintruth::sim::scenes {

struct PlanarPose {
  double x, z, angle;  // m, m, rad (picture sense)
};

// The rig of the micro-experiment as the laboratory recorded it: ten two-ball bodies in a V hopper
// over a column, let down by a piston that sinks at 46 mm/s. Wall 4 is the piston.
inline Scene micro_rig(double friction = 0.1, double restitution = 0.85) {
  Scene scene;
  scene.planar = true;
  const int polymer = scene.add_material({.youngs_modulus = 6.89e9, .poisson_ratio = 0.35});
  const int steel = scene.add_material(rigid_material());
  scene.surfaces.set(polymer, polymer, {friction, restitution});
  scene.surfaces.set(polymer, steel, {friction, restitution});
  const int body =
      scene.add_type(make_clump(chain_of_spheres(2, 0.022225, 0.02783), {.mass = 0.142}, polymer));
  const Vec2 left(-0.0675, 0.0), right(0.0675, 0.0);
  scene.add_wall(segment_wall({-0.0675, -0.28}, left, {}, steel));
  scene.add_wall(segment_wall({0.0675, -0.28}, right, {}, steel));
  scene.add_wall(segment_wall(left, {-0.240705081, 0.3}, {}, steel));
  scene.add_wall(segment_wall(right, {0.240705081, 0.3}, {}, steel));
  scene.add_wall(
      segment_wall(left, right, {.velocity = {0.0, 0.0, -0.046}, .start_time = 0.2}, steel));
  constexpr std::array<PlanarPose, 10> start{{{0.04086, 0.0223, 0.0057},
                                              {-0.06764, 0.04468, 2.0941},
                                              {-0.01863, 0.03609, 1.6532},
                                              {0.03541, 0.06646, 0.0016},
                                              {-0.02936, 0.09108, 0.2284},
                                              {0.081, 0.09437, 2.2928},
                                              {-0.10377, 0.10727, 2.0944},
                                              {0.01839, 0.12078, 2.3052},
                                              {-0.05162, 0.12957, 0.2275},
                                              {0.11953, 0.13457, 1.0472}}};
  for (const PlanarPose& pose : start) scene.add_planar_body(body, {pose.x, pose.z}, pose.angle);
  return scene;
}

}  // namespace graintruth::sim::scenes
