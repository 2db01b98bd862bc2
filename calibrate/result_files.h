// What a calibration or validation leaves in its run folder: result.json, measured.json and the
// tables of the report.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "calibrate/calibration.h"
#include "datasets/run_folder.h"

namespace graintruth::calibrate {

// `wall_time` in s. Every file is written whole, then renamed.
void write_calibration(const datasets::RunFolder& folder,
                       const Problem& problem,
                       const CalibrationOptions& options,
                       const CalibrationResult& result,
                       double wall_time);

// The table of the search, evaluation by evaluation.
void write_evaluations(const std::filesystem::path& file,
                       const Problem& problem,
                       std::span<const Evaluation> evaluations);

struct ValidationResult {
  ParameterSet parameters;
  double time_step_fraction = 0.0;
  Score score;
  ScoreContext context;
  std::vector<std::string> warnings;
};

void write_validation(const datasets::RunFolder& folder,
                      const Problem& problem,
                      const ValidationResult& result,
                      double wall_time);

}  // namespace graintruth::calibrate
