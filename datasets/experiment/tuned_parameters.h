// [tune]: the parameters that a calibration may move. For the .cpp files of this folder only.
#pragma once

#include <span>

#include "datasets/experiment/experiment.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

// Bounds and priors, the rule of the time step and the form of the objective. A prior may refer to
// the experiment's bench values, which have been read. `scenes` have the walls that a parameter may
// name.
void read_tuned(TomlSection section,
                std::span<const SceneData* const> scenes,
                Experiment& experiment);

}  // namespace graintruth::datasets
