// The parts of result.json and its tables that every calibration has. For the result writers of
// this folder alone.
#pragma once

#include <nlohmann/json.hpp>

#include "calibrate/evaluation_table.h"
#include "calibrate/search.h"
#include "datasets/run_folder.h"

namespace graintruth::calibrate {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written, for readers

Json head_json(const datasets::Experiment& experiment, const char* kind);
// Parameters, time step, objective, counts and warnings.
void add_search(const SearchResult& result, const CalibrationOptions& options, Json& json);
// Parameters that were given, not tuned.
void add_given_parameters(const datasets::Experiment& experiment,
                          const ParameterSet& parameters,
                          Json& json);
void write_json(const std::filesystem::path& file, const Json& json);

// tables/profile.csv.
void write_profiles(const datasets::RunFolder& folder, const SearchResult& result);

}  // namespace graintruth::calibrate
