#include "calibrate/search/time_step_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace graintruth::calibrate {

namespace {

constexpr std::array<double, 3> shares = {1.0, 0.5, 0.25};  // of the largest fraction
constexpr double confidence_95 = 1.96;                      // standard errors

TimeStepRow row_of(const Comparison& comparison, const Evaluation& at, const Evaluation* at_half) {
  TimeStepRow row{.parameters = at.parameters,
                  .fraction = at.time_step_fraction,
                  .time_step = at.runs.front().time_step,
                  .objective = at.objective,
                  .change = std::numeric_limits<double>::quiet_NaN(),
                  .noise = std::numeric_limits<double>::quiet_NaN(),
                  .seconds = at.seconds,
                  .failed = at.failed + at.retried};
  if (at_half == nullptr) return row;
  row.change = at.objective - at_half->objective;
  row.noise = std::hypot(comparison.noise(at.runs), comparison.noise(at_half->runs));
  return row;
}

}  // namespace

TimeStepChoice choose_time_step(Ensemble& ensemble,
                                std::span<const ParameterSet> places,
                                double largest,
                                std::span<const std::uint64_t> seeds,
                                const SimulationProgress& progress) {
  // 1. Everything at once: places x shares
  std::vector<EvaluationPoint> points;
  for (const ParameterSet& place : places) {
    for (const double share : shares) points.push_back({place, share * largest});
  }
  const std::vector<Evaluation> evaluations =
      ensemble.evaluate("time_step", points, seeds, progress);

  // 2. The change from each fraction to its half
  TimeStepChoice choice;
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    const bool has_half = (i + 1) % shares.size() != 0;
    choice.rows.push_back(
        row_of(ensemble.comparison(), evaluations[i], has_half ? &evaluations[i + 1] : nullptr));
  }

  // 3. The largest that passes everywhere
  for (std::size_t s = 0; s < shares.size() && !choice.converged; ++s) {
    const bool smallest = s + 1 == shares.size();
    bool passes = !smallest;
    double error = 0.0;
    for (std::size_t place = 0; place < places.size(); ++place) {
      const TimeStepRow& row = choice.rows[place * shares.size() + s];
      // Of the smallest only the step from twice its size is known.
      const double change =
          smallest ? choice.rows[place * shares.size() + s - 1].change : row.change;
      passes = passes && row.failed == 0 && std::abs(change) <= confidence_95 * row.noise;
      error = std::max(error, std::abs(change));
      choice.time_step = row.time_step;
    }
    choice.fraction = shares[s] * largest;
    choice.discretisation_error = error;
    choice.converged = passes;
  }
  return choice;
}

double discretisation_error_at(const TimeStepChoice& choice, double fraction) {
  std::map<double, double> error_of = {{0.0, 0.0}};
  for (const TimeStepRow& row : choice.rows) {
    if (std::isnan(row.change)) continue;
    double& error = error_of[row.fraction];
    error = std::max(error, std::abs(row.change));
  }
  const auto above = error_of.lower_bound(fraction);
  if (above == error_of.end()) return error_of.rbegin()->second;
  if (above == error_of.begin()) return 0.0;
  const auto below = std::prev(above);
  const double share = (fraction - below->first) / (above->first - below->first);
  return below->second + share * (above->second - below->second);
}

}  // namespace graintruth::calibrate
