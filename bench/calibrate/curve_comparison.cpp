#include "bench/calibrate/curve_comparison.h"

#include <array>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <limits>

#include "calibrate/ensemble.h"
#include "calibrate/hypothesis_tests.h"

namespace graintruth::bench {

using calibrate::Evaluation;
using calibrate::SimulatedRun;

namespace {

double mean_square(std::span<const double> values) {
  double mean = 0.0;
  for (const double value : values) mean += value * value / static_cast<double>(values.size());
  return mean;
}

}  // namespace

double percent_at(const SimulatedRun& run, double time) {
  const calibrate::Discharge& discharge = run.bin.discharge;
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
  return mean_square(residuals);
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

std::vector<std::vector<double>> CurveComparison::draw_objectives(
    std::span<const Evaluation> evaluations, const calibrate::BootstrapOptions& options) const {
  std::vector<std::vector<double>> seen;
  for (const Evaluation& evaluation : evaluations) seen.push_back(residuals(evaluation.runs));
  boost::random::mt19937_64 generator(options.seed);
  boost::random::uniform_int_distribution<std::size_t> which(0, points_.size() - 1);
  std::vector<std::vector<double>> drawn(static_cast<std::size_t>(options.draws));
  for (std::vector<double>& objectives : drawn) {
    // The same points for all evaluations
    std::vector<std::size_t> chosen(points_.size());
    for (std::size_t& point : chosen) point = which(generator);
    for (const std::vector<double>& of_evaluation : seen) {
      std::vector<double> differences;
      differences.reserve(chosen.size());
      for (const std::size_t point : chosen) differences.push_back(of_evaluation[point]);
      objectives.push_back(mean_square(differences));
    }
  }
  return drawn;
}

double CurveComparison::significance() const {
  return calibrate::student_t_quantile(0.975, freedom());
}

double CurveComparison::half_width_of_difference(const Evaluation& first,
                                                 const Evaluation& second,
                                                 const calibrate::PooledChance& chance,
                                                 const calibrate::BootstrapOptions& options) const {
  const std::array<Evaluation, 2> both = {first, second};
  return significance() *
         std::hypot(calibrate::difference_deviation(draw_objectives(both, options)),
                    chance.roughness * std::hypot(first.objective, second.objective));
}

double CurveComparison::allowed_excess(const Evaluation& best,
                                       const Evaluation&,
                                       const calibrate::PooledChance&,
                                       const calibrate::BootstrapOptions&) const {
  const boost::math::fisher_f distribution(tuned_, freedom());
  return best.objective * tuned_ / freedom() * boost::math::quantile(distribution, 0.95);
}

std::unique_ptr<calibrate::Comparison> CurveComparison::with_replicates(
    std::span<const SimulatedRun>) const {
  return nullptr;
}

}  // namespace graintruth::bench
