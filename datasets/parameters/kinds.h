// Every parameter, one line each; each is defined in a file of this folder.
#pragma once

#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

extern const ParameterKind friction_particle_particle;
extern const ParameterKind friction_particle_wall;
extern const ParameterKind friction_particle_surface;
extern const ParameterKind restitution;

}  // namespace graintruth::datasets
