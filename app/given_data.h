// What a replicate brings instead of a film: tracks or a discharge curve of another program, read
// and brought into the form that films are tracked into.
#pragma once

#include "datasets/discharge_curve.h"
#include "datasets/experiment.h"
#include "datasets/trajectories.h"

namespace graintruth::app {

// Tracks of a program that numbers particles as it finds them are numbered as films are: by the
// stated starting places, else by rows from below. Throws datasets::InputError for a file that
// cannot be used.
datasets::Trajectories read_given_tracks(const datasets::Experiment& experiment,
                                         const datasets::Replicate& replicate);

// Throws datasets::InputError for a file that cannot be used.
datasets::DischargeCurve read_given_curve(const datasets::Experiment& experiment,
                                          const datasets::Replicate& replicate);

}  // namespace graintruth::app
