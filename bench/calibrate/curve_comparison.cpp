#include "bench/calibrate/curve_comparison.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "bench/calibrate/hopper.h"
#include "calibrate/compare/hypothesis_tests.h"

namespace graintruth::bench {

using calibrate::Evaluation;
using calibrate::SimulatedRun;

double percent_at(const SimulatedRun& run, double time) {
  const calibrate::Discharge discharge = discharge_of(run);
  if (discharge.particles == 0) return 0.0;
  return 100.0 * calibrate::discharged_by(discharge, time) / discharge.particles;
}

CurveComparison::CurveComparison(std::vector<CurvePoint> points, int tuned)
    : points_(std::move(points)), tuned_(tuned) {}

double CurveComparison::scatter(double lowest_objective) const {
  return std::sqrt(static_cast<double>(points_.size()) * lowest_objective / freedom());
}

std::vector<double> CurveComparison::residuals(std::span<const SimulatedRun> runs) const {
  std::vector<double> differences;
  for (const CurvePoint& point : points_) {
    double simulated = 0.0;
    for (const SimulatedRun& run : runs)
      simulated += percent_at(run, point.time) / static_cast<double>(runs.size());
    differences.push_back(simulated - point.percent);
  }
  return differences;
}

double CurveComparison::objective(std::span<const SimulatedRun> runs) const {
  return loss(residuals(runs));
}

double CurveComparison::loss(std::span<const double> residuals) const {
  double mean = 0.0;
  for (const double value : residuals)
    mean += value * value / static_cast<double>(residuals.size());
  return mean;
}

double CurveComparison::noise(std::span<const SimulatedRun> runs) const {
  std::vector<double> without_one;
  for (std::size_t left_out = 0; left_out < runs.size(); ++left_out) {
    std::vector<SimulatedRun> others(runs.begin(), runs.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    if (!others.empty()) without_one.push_back(objective(others));
  }
  return calibrate::jackknife_error(without_one);
}

calibrate::RunScore CurveComparison::score_run(const SimulatedRun& run, std::size_t) const {
  return {objective({&run, 1}), std::numeric_limits<double>::quiet_NaN()};
}

double CurveComparison::significance() const {
  return calibrate::student_t_quantile(0.975, freedom());
}

double CurveComparison::half_width_of_difference(const Evaluation& first,
                                                 const Evaluation& second,
                                                 const calibrate::PooledChance& chance) const {
  const bool first_is_best = first.objective < second.objective;
  return first_is_best ? allowed_excess(first, second, chance)
                       : allowed_excess(second, first, chance);
}

double CurveComparison::allowed_excess(const Evaluation& best,
                                       const Evaluation&,
                                       const calibrate::PooledChance&) const {
  const boost::math::fisher_f distribution(tuned_, freedom());
  return best.objective * tuned_ / freedom() * boost::math::quantile(distribution, 0.95);
}

std::unique_ptr<calibrate::Comparison> CurveComparison::with_replicates(
    std::span<const SimulatedRun>) const {
  return nullptr;
}

}  // namespace graintruth::bench
