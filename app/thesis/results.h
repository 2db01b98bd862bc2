// What reproduce leaves: a CSV table a target, result.json, and lines on the terminal.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "app/thesis/row.h"
#include "app/thesis/thesis_data.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

// tables/<target>.csv
void write_target_table(const datasets::RunFolder& folder, const TargetResult& target);

nlohmann::ordered_json reproduction_result(std::span<const TargetResult> targets,
                                           std::span<const Erratum> errata);

std::string target_text(const TargetResult& target);

bool has_failed(const TargetResult& target);

}  // namespace graintruth::app
