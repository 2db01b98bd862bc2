// Films of an experiment to tracks in a run folder: every film once, several at a time, nothing
// done twice.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/progress.h"
#include "datasets/discharge_curve.h"
#include "datasets/experiment.h"
#include "datasets/run_folder.h"
#include "datasets/trajectories.h"

namespace graintruth::app {

struct TrackedFilms {
  std::vector<datasets::Trajectories> tracks;  // in the order of the experiment file
  // Of the same length; given where a replicate of a bin is a discharge curve, without tracks
  std::vector<std::optional<datasets::DischargeCurve>> curves;
  std::map<std::string, std::string> input_hashes;  // file name -> content hash
  std::vector<std::string> warnings;
};

// Tracks each replicate's film, or reads back what an earlier run left for the very same film and
// rig; tracks and discharge curves of other programs are read. Writes tracks/*, and tracking.json
// in the end. Throws calibrate::Interrupted on Ctrl-C; films that were done by then stay done.
TrackedFilms track_films(const datasets::Experiment& experiment,
                         const datasets::RunFolder& folder,
                         int jobs,
                         ProgressLine& progress);

}  // namespace graintruth::app
