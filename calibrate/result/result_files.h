// What a calibration or validation leaves in its run folder: result.json, measured.json and the
// tables of the report. Every file is written whole, then renamed.
#pragma once

#include <string>
#include <vector>

#include "calibrate/calibration.h"
#include "calibrate/search/evaluation_table.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

// measured.json and its tables, of the recordings alone; returns what a person wants to read first.
std::vector<std::string> write_measured(const datasets::RunFolder& folder,
                                        const datasets::Experiment& experiment,
                                        std::span<const datasets::Recording> recordings);

// Of one experiment; `wall_time` in s. Returns what a person wants to read first. Warnings that
// results bring with them are added to those of the result.
std::vector<std::string> write_calibration(const datasets::RunFolder& folder,
                                           const Problem& problem,
                                           const CalibrationOptions& options,
                                           ExperimentResult& result,
                                           double wall_time);

// Of several experiments: the whole, beside the folders of each.
void write_calibration_of_several(const datasets::RunFolder& folder,
                                  const datasets::Experiment& common,
                                  std::span<const CalibratedExperiment> experiments,
                                  const CalibrationOptions& options,
                                  const CalibrationResult& result,
                                  double wall_time);

struct Validation {
  std::vector<datasets::Warning> warnings;  // of the films
  std::vector<std::string> lines;           // out: what a person wants to read first
  double agreement_percent = 0.0;           // out: Student; NaN where there is no agreement
};
void write_validation(const datasets::RunFolder& folder,
                      const Problem& problem,
                      const Confirmed& confirmed,
                      double wall_time,
                      Validation& validation);

// Percent of an evaluation's mean run, Student form; NaN where there is no agreement. `comparison`
// must outlive it.
EvaluationAgreement agreement_of(const ChannelComparison& comparison);

}  // namespace graintruth::calibrate
