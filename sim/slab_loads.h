// What the contacts of a slab of bodies do: the sums that are not those of its own bodies.
#pragma once

#include <vector>

#include "sim/bodies.h"

namespace graintruth::sim {

// The body and the partner of the worst overlap, when one was too large.
struct OverlapTrouble {
  bool found = false;
  int first = -1;
  int second = -1;
  bool with_wall = false;
  double overlap = 0.0;  // m
};

// Sum of the contacts of a slab on a wall.
template <int D>
struct WallLoad {
  Vec<D> force = Vec<D>::Zero();                           // N
  typename Motion<D>::Spin torque = Motion<D>::no_spin();  // N m, about the origin
};

// What a contact does to a body of a later slab.
template <int D>
struct DeferredLoad {
  int body;
  Load<D> load;
};

// Loads on bodies of later slabs are summed for themselves, in the order of the slabs that they
// come from, and added to those of their own slab at the end. Slabs that are done one after the
// other sum them at once; of slabs that are done at the same time they are put off.
template <int D>
struct SlabLoads {
  int end = 0;  // its bodies are those before
  bool puts_off = false;
  std::vector<DeferredLoad<D>> deferred;
  std::vector<WallLoad<D>> walls;
  OverlapTrouble trouble;
  int contact_count = 0;
};

}  // namespace graintruth::sim
