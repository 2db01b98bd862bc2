// What a calibration or validation leaves in its run folder: result.json, measured.json and the
// tables of the report.
#pragma once

#include <string>

#include "calibrate/calibration.h"
#include "calibrate/evaluation_table.h"
#include "datasets/run_folder.h"

namespace graintruth::calibrate {

// `wall_time` in s. Every file is written whole, then renamed.
void write_calibration(const datasets::RunFolder& folder,
                       const Problem& problem,
                       const CalibrationOptions& options,
                       const CalibrationResult& result,
                       double wall_time);

// Percent of an evaluation's mean run, Student form. `problem` must outlive it.
EvaluationAgreement agreement_of(const Problem& problem);

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
