// What studies of twins write down: one row a twin, kept as it ends, so that a study goes on where
// it stopped.
#pragma once

#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "calibrate/knowledge/calibrated_parameter.h"
#include "datasets/experiment/experiment.h"
#include "datasets/parameters/parameter_set.h"
#include "datasets/store/table.h"

namespace graintruth::bench {

// Truth, value, ends of the interval and status of every tuned parameter: the columns of their
// names, and the cells of one twin.
std::vector<std::string> parameter_columns(const datasets::Experiment& experiment);
std::vector<std::string> parameter_cells(const datasets::Experiment& experiment,
                                         const datasets::ParameterSet& truth,
                                         std::span<const calibrate::CalibratedParameter> found);

// One parameter of one twin, as these columns tell it.
struct ToldParameter {
  double truth = 0.0;
  double value = 0.0;
  bool has_interval = false;
  calibrate::Interval interval;
  std::string status;

  bool holds_truth() const {
    return has_interval && interval.lower <= truth && truth <= interval.upper;
  }
};
ToldParameter told_parameter(const datasets::Table& table, std::size_t row, std::string_view name);

// The rows of a study in a CSV file, in the order of their numbers. The first column is the number.
// Any thread may call it.
class TwinRows {
 public:
  // Reads what an earlier run has left of the first `twins` twins.
  TwinRows(std::filesystem::path file, std::vector<std::string> columns, int twins);

  bool has(int number);
  // Writes the file anew, with this row.
  void keep(int number, std::vector<std::string> cells);
  datasets::Table table();

 private:
  datasets::Table whole() const;

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;  // of the numbers; empty where there is none yet
  std::mutex mutex_;
};

}  // namespace graintruth::bench
