// What a replicate brings instead of a film: tracks or a discharge curve of another program, read
// and brought into the form that films are tracked into.
#pragma once

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"

namespace graintruth::app {

struct GivenData {
  datasets::Recording recording;
  // Particles bear numbers of the program's choice, which places of another replicate may change:
  // the file has them as they were found, and the experiment states no starting places.
  bool is_numbered_by_us = false;
};

// Everything that a replicate brings: tracks, a discharge curve, curves of its own. Tracks of a
// program that numbers particles as it finds them are numbered as films are: by the stated starting
// places, else by rows from below. Throws datasets::InputError for a file that cannot be used.
GivenData read_given_data(const datasets::Experiment& experiment,
                          const datasets::Replicate& replicate);

// Numbers particles like those of the replicate that each is numbered like (numbering.h), as far as
// that one is known: by the nearest places, all together.
void number_alike(const datasets::Experiment& experiment, std::vector<GivenData>& given);

}  // namespace graintruth::app
