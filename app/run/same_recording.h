// Replicates that are one recording under two names.
#pragma once

#include <span>

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"

namespace graintruth::app {

// Throws datasets::InputError that names both files where two replicates show the same film, byte
// for byte, or the same tracks or curves, number for number, however they are written. Twice the
// same is no repeat: it would make every interval too narrow. `recordings` are those of the
// replicates; what comes from films is compared by the films.
void require_different(const datasets::Experiment& experiment,
                       std::span<const datasets::Recording> recordings);

}  // namespace graintruth::app
