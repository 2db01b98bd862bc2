// A row of balls on an incline, at rest: sliding, sticking and rolling start from it.
#pragma once

#include <cmath>

#include "sim/simulation.h"

namespace graintruth::sim::cases {

constexpr double kGravity = 9.81;  // m/s2

// A row of touching balls flat on a plane whose gravity is tilted by `incline`, started at its
// static overlap.
inline Scene on_incline(int spheres,
                        double radius,
                        double incline,
                        const Surfaces& surfaces,
                        bool planar,
                        double gravity = kGravity) {
  Scene scene;
  scene.planar = planar;
  scene.gravity = gravity * Vec3(std::sin(incline), 0.0, -std::cos(incline));
  const int material = scene.add_material({3.5e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, surfaces);
  const int type = scene.add_type(
      make_clump(chain_of_spheres(spheres, radius, 2.0 * radius), {.density = 1256.4}));
  const double modulus =
      mix(scene.materials[0], scene.materials[1], {}, Tension::allowed, 0.0).normal_modulus;
  const double k = 4.0 / 3.0 * modulus * std::sqrt(radius);
  const double overlap =
      std::pow(-scene.types[type].mass * scene.gravity.z() / (spheres * k), 2.0 / 3.0);
  scene.add_body(type, {0.0, 0.0, radius - overlap});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  return scene;
}

}  // namespace graintruth::sim::cases
