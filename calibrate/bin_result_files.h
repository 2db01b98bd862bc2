// What tracking and calibration on films of a bin leave in their run folder.
#pragma once

#include <span>

#include "calibrate/bin_calibration.h"
#include "datasets/run_folder.h"

namespace graintruth::calibrate {

// measured.json, and the tables discharge, flow_rates and velocity_profiles. `records` are those of
// the films.
void write_bin_measurements(const datasets::RunFolder& folder,
                            const datasets::Experiment& experiment,
                            std::span<const FilmedBin> films,
                            std::span<const BinRecord> records,
                            const BinFits& fits);

// result.json and the tables of the report; `wall_time` in s.
void write_bin_calibration(const datasets::RunFolder& folder,
                           const BinProblem& problem,
                           const CalibrationOptions& options,
                           const BinCalibrationResult& result,
                           double wall_time);

struct BinValidationResult {
  ParameterSet parameters;
  double time_step_fraction = 0.0;
  BinScore score;
  std::vector<std::string> warnings;
};

void write_bin_validation(const datasets::RunFolder& folder,
                          const BinProblem& problem,
                          const BinValidationResult& result,
                          double wall_time);

}  // namespace graintruth::calibrate
