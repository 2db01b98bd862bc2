// Scenes that several tests and benchmarks start from.
#pragma once

#include <array>

#include "sim/engine/relaxation.h"
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

// Rows of chains of `spheres` balls of 5 mm above a box that fits them, dropped as they lie, turned
// by some steps of a coarse wheel so that no two neighbours are alike. In space as many layers deep
// as `depth` says.
struct BedSize {
  int columns = 10, rows = 6, depth = 1, spheres = 3;
  double gap = 1e-3;  // m; between the sites
};
inline Scene falling_bed(const BedSize& size, bool planar, const Surfaces& surfaces) {
  constexpr double kRadius = 0.005, kSpacing = 0.006;  // m
  Scene scene;
  scene.planar = planar;
  const int grain = scene.add_material({.youngs_modulus = 1e7, .poisson_ratio = 0.3});
  const int steel = scene.add_material(rigid_material());
  scene.surfaces.set(grain, grain, surfaces);
  scene.surfaces.set(grain, steel, surfaces);
  const int type = scene.add_type(
      make_clump(chain_of_spheres(size.spheres, kRadius, kSpacing), {.density = 1500.0}, grain));
  const double site = 2.0 * kRadius + (size.spheres - 1) * kSpacing + size.gap;
  for (int k = 0; k < size.rows; ++k) {
    for (int j = 0; j < size.depth; ++j) {
      for (int i = 0; i < size.columns; ++i) {
        const int turn = (7 * i + 5 * j + 11 * k) % 16;
        const Vec3 place((i + 0.5) * site, (j + 0.5) * site, (k + 0.5) * site);
        if (planar) {
          scene.add_planar_body(type, into_plane(place), 0.2 * turn);
        } else {
          const Quat turned(1.0, 0.1 * turn, 0.3 - 0.05 * turn, 0.2 * (turn % 5));
          scene.add_body(type, place, turned.normalized());
        }
      }
    }
  }
  const Vec3 far(size.columns * site, size.depth * site, 0.0);
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, steel));
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitX(), {}, steel));
  scene.add_wall(plane_wall(far, -Vec3::UnitX(), {}, steel));
  if (planar) return scene;
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitY(), {}, steel));
  scene.add_wall(plane_wall(far, -Vec3::UnitY(), {}, steel));
  return scene;
}

}  // namespace graintruth::sim::scenes
