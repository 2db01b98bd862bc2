// What outlines themselves show to be wrong: beds that were not at rest, that reached a wall, that
// stand elsewhere than the rig says.
#pragma once

#include <span>
#include <vector>

#include "calibrate/problem.h"
#include "datasets/verdict/warning.h"

namespace graintruth::calibrate {

// Warnings of the first line, one sentence each; none of a rig that is not seen by its outline.
// - A bed at rest that is higher than a grain within a grain of an end that it did not touch before
//   the event.
// - A bed that still moves at the end: within the last ten times that a grain takes to fall by
//   itself, sqrt(2 d / g), columns of one and a half grains changed by more than three standard
//   uncertainties, and more than a tenth of a grain.
// - A bed that lies at the other end of its tank, or in a drum rises on the other side, than it
//   must: a mirrored picture.
// - A column that before the event is wider or narrower than stated, by more than half a grain.
// - Heaps of a tube whose middles lie off its axis, all in one way: on average by a quarter of a
//   grain, and by more than chance gives in one of a hundred experiments (Student). Three heaps
//   hardly show how heaps scatter; half a grain shows from some five on.
std::vector<datasets::Warning> doubts_about_outlines(
    const datasets::Experiment& experiment, std::span<const datasets::Recording> recordings);

}  // namespace graintruth::calibrate
