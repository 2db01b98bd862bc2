// The films that a bench of tracking reads.
#pragma once

#include <string>
#include <vector>

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::bench {

// A film, how it is to be tracked, and the experiment that names it.
struct Filmed {
  datasets::Experiment experiment;
  datasets::Replicate replicate;
  datasets::Film film;
  datasets::TrackingSpec spec;  // of the recording
};

// The films of the experiment `file`, or where that is empty all of the bundled data set of this
// name; those whose name holds `part`, each name once. Says which experiments cannot be read.
std::vector<Filmed> films_of(const std::string& data_set,
                             const std::string& file,
                             const std::string& part);

// The films of pale balls on pale ground, of the same rig as the bundled micro films, where the
// shared data lie beside the repository; else none. Named "pale rep1" and so on.
std::vector<Filmed> pale_films();

// When the piston starts in all of them, s of film: frame 10 of 50 a second.
constexpr double micro_event_s = 0.2;

}  // namespace graintruth::bench
