// Films of an experiment to tracks in a run folder: every film once, several at a time, nothing
// done twice.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/run/progress.h"
#include "calibrate/knowledge/foreign_replicates.h"
#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/trajectories.h"
#include "datasets/verdict/warning.h"

namespace graintruth::app {

struct TrackedFilms {
  std::vector<datasets::Recording> recordings;  // in the order of the experiment file
  std::vector<double> event_times;  // s of film; of the same length, 0 where there is no film
  std::vector<char> is_smeared;     // of the same length: moving particles cannot be followed
  std::map<std::string, std::string> input_hashes;  // file name -> content hash
  // What puts a replicate in doubt: said before everything else
  std::vector<datasets::Warning> doubts;
  std::vector<datasets::Warning> warnings;
  std::vector<std::string>
      failures;  // "rep3 (why)" of each film that is graded "fail" and compared
  // What films tell of the grains in them, of every replicate: their radius, say
  std::vector<calibrate::RepeatedQuantity> seen;
};

// Tracks each replicate's film, or reads back what an earlier run left for the very same film and
// rig, if no file of it was changed since: else the film is tracked again, and that is said. Tracks
// and discharge curves of other programs are read. Writes tracks/*, and tracking.json in the end.
// Throws calibrate::Interrupted on Ctrl-C; films that were done by then stay done.
TrackedFilms track_films(const datasets::Experiment& experiment,
                         const datasets::RunFolder& folder,
                         int jobs,
                         ProgressLine& progress);

}  // namespace graintruth::app
