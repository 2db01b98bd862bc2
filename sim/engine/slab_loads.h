// What the contacts of a slab of bodies do: the sums that are not those of its own bodies.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sim/engine/bodies.h"

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

// A bed has at most so many parts, of 2^shift bodies each.
constexpr int kBedParts = 16;
inline int part_of(int body, int shift) { return body >> shift; }
inline int part_shift_of(int bodies) {
  int shift = 0;
  while (part_of(std::max(bodies - 1, 0), shift) >= kBedParts) ++shift;
  return shift;
}

// What a contact does to a body of a later slab.
template <int D>
struct DeferredLoad {
  int body;
  Load<D> load;
};

// Loads on bodies of later slabs are summed for themselves, in the order of the slabs that they
// come from, and added to those of their own slab at the end. Slabs that are done one after the
// other sum them at once; of slabs that are done at the same time they are put off, sorted by parts
// of the bed so that its parts can be summed at the same time too.
template <int D>
struct SlabLoads {
  int end = 0;  // its bodies are those before
  bool puts_off = false;
  int part_shift = 0;  // see part_of
  std::array<std::vector<DeferredLoad<D>>, kBedParts> deferred;
  std::vector<WallLoad<D>> walls;
  OverlapTrouble trouble;
  int contact_count = 0;

  void put_off(int body, const Load<D>& load) {
    deferred[part_of(body, part_shift)].push_back({body, load});
  }
};

}  // namespace graintruth::sim
