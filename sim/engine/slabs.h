// Slabs: bodies that lie side by side in memory, taken together by whoever is free.
#pragma once

#include <algorithm>

#include "sim/engine/team.h"

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

// task(worker, i) for all i in [0, count), slabs or parts of the bed, shared by the team; all of
// them by worker 0 where there is none, or nothing to share.
template <class Task>
void for_each_shared(int count, Team* team, const Task& task) {
  if (team != nullptr && team->workers() > 1 && count > 1) {
    team->run(count, task);
  } else {
    for (int i = 0; i < count; ++i) task(0, i);
  }
}

}  // namespace graintruth::sim
