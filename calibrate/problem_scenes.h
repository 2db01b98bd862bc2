// What is simulated for an experiment: grains, and from where each simulation begins.
#pragma once

#include "calibrate/problem.h"

namespace graintruth::calibrate {

// A scene for every condition, or for every replicate whose start is its own. Needs conditions,
// observables and the engine. Throws datasets::InputError where recordings do not tell a start.
void make_scenes(std::span<const datasets::Recording> recordings, Problem& problem);

// Warns those whose recordings do not tell a bed.
void say_what_is_prepared(std::span<const datasets::Recording> recordings, Problem& problem);

}  // namespace graintruth::calibrate
