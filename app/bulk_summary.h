// What the films of a bin told: measured.json and its tables, from tracks alone.
#pragma once

#include <string>
#include <vector>

#include "app/films.h"
#include "calibrate/bin_score.h"
#include "datasets/experiment.h"
#include "datasets/run_folder.h"
#include "datasets/trajectories.h"

namespace graintruth::app {

// Whether particles run out of the rig of this experiment; whether films tell how many.
bool runs_out(const datasets::Experiment& experiment);
bool measures_flow(const datasets::Experiment& experiment);

// Films of a bin that can be measured, and their tracks or discharge curves.
struct BinFilms {
  datasets::Experiment experiment;  // with the replicates of these films alone
  std::vector<calibrate::BinRecord> records;
  std::vector<std::string> left_out;  // names of films whose moving plates are smeared
};

// Leaves out films with smeared plates: only their bed at rest can be followed, and it would look
// as if all else had left. Reads tracking.json.
BinFilms measurable_films(const datasets::Experiment& experiment,
                          const TrackedFilms& films,
                          const datasets::RunFolder& folder);

// Discharge, steady rate, pauses, bed and velocity profile of each replicate; rate of each orifice
// with its interval from the scatter of replicates; Beverloo's C and k where there are at least
// three orifices; the kinematic B of each orifice. Writes measured.json and tables/*.csv, and
// returns what a person wants to read first.
std::string write_bulk_measurements(const BinFilms& films, const datasets::RunFolder& folder);

// Rates filmed and simulated, a line an orifice.
std::string words_on(const calibrate::BinScore& score);

}  // namespace graintruth::app
