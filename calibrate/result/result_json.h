// The parts of result.json and its tables that every calibration has. For the result writers of
// this folder alone.
#pragma once

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

// tables/profile.csv.
void write_profiles(const datasets::RunFolder& folder, const SearchResult& result);

}  // namespace graintruth::calibrate
