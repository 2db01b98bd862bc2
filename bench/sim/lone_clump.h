// One clump alone above or on a plane: the problems whose answers are known exactly, for every
// engine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene.h"

namespace graintruth::bench {

struct LoneClump {
  std::vector<sim::ElementSphere> spheres;                // body frame, long axis x
  double mass = 0.020;                                    // kg
  sim::Vec3 inertia = sim::Vec3(0.8e-6, 1.6e-6, 1.6e-6);  // kg m2
  sim::Material material = {.youngs_modulus = 3.5e9, .poisson_ratio = 0.3};
  double restitution = 1.0;
  double friction = 0.0;
  sim::Vec3 gravity = sim::Vec3(0.0, 0.0, -9.81);
  sim::Vec3 position = sim::Vec3::Zero();
  bool is_upright = false;                         // long axis along z, else along x
  sim::Vec3 velocity = sim::Vec3::Zero();          // m/s
  sim::Vec3 angular_velocity = sim::Vec3::Zero();  // rad/s
  double time_step = 1e-6;                         // s
  std::vector<int> look_at_steps;                  // ascending

  sim::Quat orientation() const;
};

// Centres of the spheres at the steps asked for.
using SphereTrack = std::vector<std::vector<sim::Vec3>>;

SphereTrack track_by_graintruth(const LoneClump& clump);
SphereTrack track_by_lammps(const LoneClump& clump, const std::filesystem::path& folder);
SphereTrack track_by_liggghts(const LoneClump& clump, const std::filesystem::path& folder);

}  // namespace graintruth::bench
