// What a calibration or validation tells, as it comes together: result.json, tables, sentences.
// Brings in the JSON library; for .cpp files.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"
#include "datasets/verdict/warning.h"

namespace graintruth::calibrate {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written, for readers

struct Results {
  Json json = Json::object();
  std::map<std::string, datasets::Table> tables;  // by name
  std::vector<datasets::Warning> warnings;
  std::vector<std::string> lines;  // what a person wants to read first
};

// Every table of the results.
void write_tables(const datasets::RunFolder& folder, const Results& results);
void write_json(const std::filesystem::path& file, const Json& json);

}  // namespace graintruth::calibrate
