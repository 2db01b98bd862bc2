// The surfaces of the walls: how they move, what they are made of, which are of one body.
#pragma once

#include <vector>

#include "sim/engine/bodies.h"
#include "sim/engine/slab_loads.h"
#include "sim/shapes/walls.h"

namespace graintruth::sim {

template <int D>
struct WallSurfaces {
  // Of the point at the origin, as if the wall were a body there: at p its velocity is
  // velocity + spin x p
  std::vector<BodyMotion<D>> motion;
  std::vector<int> material;
  WallBodies bodies;
  std::vector<char> turns;        // else the spins are zero and the torque is not summed
  std::vector<WallLoad<D>> load;  // of the last step

  void resize(std::size_t count) {
    motion.resize(count, BodyMotion<D>{});
    material.resize(count);
    turns.resize(count, 0);
    load.resize(count);
  }
};

}  // namespace graintruth::sim
