#include "calibrate/comparison.h"

#include <cmath>

namespace graintruth::calibrate {

void count_runs(Evaluation& evaluation) {
  for (const SimulatedRun& run : evaluation.runs) {
    evaluation.failed += run.status != RunStatus::completed;
    evaluation.retried += run.status == RunStatus::completed && !run.message.empty();
    evaluation.seconds += run.seconds;
  }
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

double difference_deviation(std::span<const std::vector<double>> drawn) {
  const auto n = static_cast<double>(drawn.size());
  double mean = 0.0;
  for (const auto& draw : drawn) mean += (draw[0] - draw[1]) / n;
  double squares = 0.0;
  for (const auto& draw : drawn) squares += std::pow(draw[0] - draw[1] - mean, 2);
  return std::sqrt(squares / (n - 1.0));
}

}  // namespace graintruth::calibrate
