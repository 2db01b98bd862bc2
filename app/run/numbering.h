// Particles of replicates that repeat each other bear the numbers of the same places.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"
#include "datasets/verdict/warning.h"

namespace graintruth::app {

// Whether a number must mean the same place in all replicates: where they begin from one start, or
// are only tracked. Grains that fall into a rig have no places of their own.
bool are_numbered_alike(const datasets::Experiment& experiment);

// The replicate whose places give this one its numbers: the first of the same settings.
std::size_t numbered_like(const datasets::Experiment& experiment, std::size_t replicate);

// Where the particles of a recording start, in the order of their numbers; none where it does not
// show every particle of the experiment.
std::optional<std::vector<datasets::StartPlace>> places_in(const datasets::Experiment& experiment,
                                                           const datasets::Recording& recording);

// A warning of every replicate whose particles do not start where those of the same numbers start
// in the replicate that it is numbered like. A particle is at its place as long as it lies nearer
// to it than half the smallest distance between two places: then no other place can be nearer.
std::vector<datasets::Warning> compare_starts(const datasets::Experiment& experiment,
                                              std::span<const datasets::Recording> recordings);

}  // namespace graintruth::app
