// Snapshot: everything that decides how a simulation goes on, to save it and to go on from there
// with the same bits. In memory; files are the caller's affair.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/laws/material.h"
#include "sim/shapes/walls.h"

namespace graintruth::sim {

// A touching contact and its tangential spring. `second` is a sphere, or a wall.
struct KeptContact {
  std::int64_t first_sphere = 0;  // counted through all bodies
  std::int64_t second = 0;
  std::int64_t state = 1;  // 1 touching, 2 sliding (static friction remembers it)
  double spring[3] = {};   // m; planar: the first alone
  // Under laws that need them, else zero: see ContactMemory
  double elastic_force = 0.0;  // N
  double stiffness = 0.0;      // N/m
  double rolled[3] = {};       // rad; planar: the first alone
};

struct Snapshot {
  // What it is a snapshot of
  std::int64_t dimensions = 0;  // 2 planar, 3 spatial
  std::int64_t body_count = 0;
  std::int64_t sphere_count = 0;

  double time = 0.0;               // s
  double time_step = 0.0;          // s; of the last step, to which the half-step velocities belong
  double longest_time_step = 0.0;  // s; that run_until may take
  double slip_time = 0.0;          // s
  double global_damping = 0.0;     // 1/s
  double damping_loss = 0.0, tangential_work = 0.0, wall_work = 0.0, crossing_work = 0.0;  // J

  // Per body, SI units. Planar: position x z, velocity (half a step back) x z, velocity now x z,
  // spin, spin now, acceleration x z, angular acceleration, picture angle, its cosine, its sine.
  // Spatial: position, velocity, velocity now, spin, spin now, acceleration, angular acceleration
  // (body axes), quaternion w x y z, spin in body axes.
  std::vector<double> bodies;
  std::vector<KeptContact> between_bodies, with_walls;
  std::vector<PairMaterial> pairs;
  std::vector<Wall> walls;  // as they were when their motion began
  // Per wall. Planar: velocity half a step back x z, velocity now x z, force x z, spin half a step
  // back, spin now, torque, 1 when it turns. Spatial: the same with vectors of three.
  std::vector<double> wall_surfaces;
};

// Numbers per body and per wall surface.
constexpr std::size_t numbers_per_body(std::int64_t dimensions) {
  return dimensions == 2 ? 14 : 28;
}
constexpr std::size_t numbers_per_wall_surface(std::int64_t dimensions) {
  return dimensions == 2 ? 10 : 19;
}

// The snapshot of what is left when the bodies marked in `gone` (one entry a body) are taken out.
// `first_sphere` is that of each body, and one past the last.
Snapshot without_bodies(const Snapshot& snapshot,
                        std::span<const char> gone,
                        std::span<const std::int64_t> first_sphere);

// The eight letters "GTSNAP04"; then the members of Snapshot in their order, integers as 64-bit and
// numbers as IEEE 754 doubles, both little-endian; a vector is its length and its elements, and so
// is every member of an element; at the end the FNV-1a hash (64 bits) of all bytes before it.
std::vector<std::byte> to_bytes(const Snapshot& snapshot);

// Throws std::invalid_argument saying what is wrong with the bytes.
Snapshot snapshot_from_bytes(std::span<const std::byte> bytes);

}  // namespace graintruth::sim
