// The parts of result.json and its tables that every calibration has. For the result writers of
// this folder alone.
#pragma once

#include "calibrate/problem.h"
#include "calibrate/result/results.h"
#include "calibrate/search/evaluation_table.h"
#include "calibrate/search/search.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

Json head_json(const datasets::Experiment& experiment, const char* kind);
// Parameters, time step, objective, counts and warnings.
void add_search(const SearchResult& result, const CalibrationOptions& options, Json& json);
// Parameters that were given, not tuned.
void add_given_parameters(const datasets::Experiment& experiment,
                          const ParameterSet& parameters,
                          Json& json);

// Every compared quantity, condition by condition, measured and simulated, of all conditions or of
// those that are calibrated on. `simulated` are the runs of their scenes.
enum class Scope { everything, calibrated };
Json channels_json(const Problem& problem, Scope scope, const std::vector<SimulatedRun>& simulated);

// tables/parameters.csv.
void write_parameters(const datasets::RunFolder& folder, const SearchResult& result);

// tables/profile.csv.
void write_profiles(const datasets::RunFolder& folder, const SearchResult& result);

}  // namespace graintruth::calibrate
