#pragma once

#include "datasets/parameters/parameter_set.h"

namespace graintruth::tests {

// The three that every experiment has.
inline datasets::ParameterSet parameters(double friction_particle_particle,
                                         double friction_particle_wall,
                                         double restitution) {
  return {{"friction_particle_particle", friction_particle_particle},
          {"friction_particle_wall", friction_particle_wall},
          {"restitution", restitution}};
}

}  // namespace graintruth::tests
