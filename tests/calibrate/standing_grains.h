// What equal balls on a perfect lattice do: stand on each other for ever.
#pragma once

#include <algorithm>
#include <vector>

#include "calibrate/engines/scene_run.h"

namespace graintruth::calibrate {

// The grain straight below each one that rests on it and touches no other; -1 for all others.
inline std::vector<int> supports_of_standing(const SceneRun& run, double diameter) {
  const std::vector<sim::Body>& bodies = run.scene.bodies;
  std::vector<int> supports(bodies.size(), -1);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    int near = 0, below = 0, support = -1;
    for (std::size_t j = 0; j < bodies.size(); ++j) {
      const sim::Vec3 apart = bodies[i].position - bodies[j].position;
      if (i == j || apart.norm() > 1.02 * diameter) continue;
      ++near;
      if (apart.z() <= 0.98 * diameter) continue;
      ++below;
      support = static_cast<int>(j);
    }
    if (below == 1 && near <= 2) supports[i] = support;
  }
  return supports;
}

// Grains that rest on one other grain, straight below them, and touch nothing else.
inline int standing_grains(const SceneRun& run, double diameter) {
  const std::vector<int> supports = supports_of_standing(run, diameter);
  return static_cast<int>(
      std::count_if(supports.begin(), supports.end(), [](int one) { return one >= 0; }));
}

// Those among them that stand on one that stands itself. Between panes, which hold it, a single
// grain may well stand on another.
inline int standing_columns(const SceneRun& run, double diameter) {
  const std::vector<int> supports = supports_of_standing(run, diameter);
  return static_cast<int>(std::count_if(supports.begin(), supports.end(), [&](int one) {
    return one >= 0 && supports[static_cast<std::size_t>(one)] >= 0;
  }));
}

}  // namespace graintruth::calibrate
