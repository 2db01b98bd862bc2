#include "calibrate/compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/flow/median.h"

namespace graintruth::calibrate {

void count_runs(Evaluation& evaluation) {
  for (const SimulatedRun& run : evaluation.runs) {
    evaluation.failed += run.status != RunStatus::completed;
    evaluation.retried += run.status == RunStatus::completed && !run.message.empty();
    evaluation.seconds += run.seconds;
  }
}

bool is_hopeless(const Evaluation& evaluation, const Evaluation& best) {
  return evaluation.objective > 6.0 * best.objective + 0.12;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double jackknife_error(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  if (values.size() < 2) return 0.0;
  double mean = 0.0;
  for (const double value : values) mean += value / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt((n - 1.0) / n * squares);
}

}  // namespace graintruth::calibrate
