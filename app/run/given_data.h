// What a replicate brings instead of a film: tracks or a discharge curve of another program, read
// and brought into the form that films are tracked into.
#pragma once

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"

namespace graintruth::app {

// Everything that a replicate brings: tracks, a discharge curve, curves of its own. Tracks of a
// program that numbers particles as it finds them are numbered as films are: by the stated starting
// places, else by rows from below. Throws datasets::InputError for a file that cannot be used.
datasets::Recording read_given_data(const datasets::Experiment& experiment,
                                    const datasets::Replicate& replicate);

}  // namespace graintruth::app
