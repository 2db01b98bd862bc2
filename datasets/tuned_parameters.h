// The parameters that a calibration may move, as [tune] states them. For the .cpp files of this
// folder only.
#pragma once

#include <array>

#include "datasets/experiment.h"
#include "datasets/toml_section.h"

namespace graintruth::datasets {

inline constexpr std::array<const char*, 3> parameter_names = {
    "friction_particle_particle", "friction_particle_wall", "restitution"};

// The values that a parameter can have.
const Range& range_of(const std::string& parameter);

// Bounds and priors, the rule of the time step and the form of the objective. A prior may refer to
// the experiment's bench values, which have been read.
void read_tuned(TomlSection section, Experiment& experiment);

}  // namespace graintruth::datasets
