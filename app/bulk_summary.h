// What the films of a bin told: measured.json and its tables, from tracks alone.
#pragma once

#include <string>
#include <vector>

#include "datasets/experiment.h"
#include "datasets/run_folder.h"
#include "datasets/trajectories.h"

namespace graintruth::app {

// Discharge, steady rate, pauses, bed and velocity profile of each replicate; rate of each orifice
// with its interval from the scatter of replicates; Beverloo's C and k where there are at least
// three orifices; the kinematic B of each orifice. Writes measured.json and tables/*.csv, and
// returns what a person wants to read first. `tracks` are in the order of the experiment's
// replicates.
std::string write_bulk_measurements(const datasets::Experiment& experiment,
                                    const std::vector<datasets::Trajectories>& tracks,
                                    const datasets::RunFolder& folder);

}  // namespace graintruth::app
