// Slabs: bodies that lie side by side in memory, taken together by whoever is free.
#pragma once

#include <algorithm>

#include "sim/team.h"

namespace graintruth::sim {

// Whole blocks of columns (see integrate.cpp); few enough to hand out, and small enough for the
// last one not to be waited for.
constexpr int kBodiesInSlab = 256;
inline int slab_of(int body) { return body / kBodiesInSlab; }
inline int slab_count_of(int bodies) { return bodies > 0 ? slab_of(bodies - 1) + 1 : 1; }

// Bodies [begin, end) of a slab.
struct SlabRange {
  int begin, end;
};
inline SlabRange slab_range(int slab, int bodies) {
  return {slab * kBodiesInSlab, std::min((slab + 1) * kBodiesInSlab, bodies)};
}

// task(worker, slab) for every slab; all of them by worker 0 when there is no team.
template <class Task>
void for_each_slab(int slabs, Team* team, const Task& task) {
  if (team != nullptr && team->workers() > 1 && slabs > 1) {
    team->run(slabs, task);
  } else {
    for (int slab = 0; slab < slabs; ++slab) task(0, slab);
  }
}

}  // namespace graintruth::sim
