#include "tests/sim/cases/check.h"

namespace graintruth::sim::cases {

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const std::span<const Case> group : {impact_cases(),
                                            friction_cases(),
                                            rotation_cases(),
                                            statics_cases(),
                                            particle_cases(),
                                            conservation_cases(),
                                            mesh_cases(),
                                            order_cases()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace graintruth::sim::cases
