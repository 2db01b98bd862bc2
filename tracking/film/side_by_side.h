// A film and a simulation of it on one clock: on the left the film with what was found drawn on it,
// on the right the simulation as the film's camera would have seen it.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

struct FilmAndSimulation {
  datasets::Film film;
  datasets::TrackingSpec recorded;          // as this film was made, see recording.h
  const datasets::Trajectories& filmed;     // a frame for every picture of the film
  const datasets::Trajectories& simulated;  // the same particles; on its own times
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
