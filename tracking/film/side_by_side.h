// A film and a simulation of it on one clock: on the left the film with what was found drawn on it,
// on the right the simulation as the film's camera would have seen it.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "datasets/experiment/recording.h"
#include "datasets/experiment/tracking_spec.h"

namespace graintruth::tracking {

// Either shows grains that are followed, or both the outline of their bed. Of tracks the film has a
// frame for every picture, and both have the same particles; each has its own times.
struct FilmAndSimulation {
  datasets::Film film;
  datasets::TrackingSpec recorded;  // as this film was made, see recording.h
  double event_time = 0.0;          // s of film
  const datasets::Recording& filmed;
  const datasets::Recording& simulated;
};

struct SideBySideFiles {
  std::filesystem::path film;                 // mp4
  std::vector<std::filesystem::path> stills;  // jpg; at equal steps of time from 0 to the end
};

// From time 0 to the end of the shorter one, at 25 pictures a second of the film's own time at
// most. Every file is written beside its place and then renamed. Returns the times of the stills,
// s; nothing where `stop`, which is asked before every picture, said so. Throws InputError where
// the film shows no scale for a camera, or a file cannot be written.
std::vector<double> draw_side_by_side(const FilmAndSimulation& both,
                                      const SideBySideFiles& files,
                                      const std::function<bool()>& stop);

}  // namespace graintruth::tracking
