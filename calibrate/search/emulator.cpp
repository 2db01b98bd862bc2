#include "calibrate/search/emulator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>

#include "calibrate/flow/median.h"
#include "calibrate/search/optimiser.h"

namespace graintruth::calibrate {

namespace {

constexpr double shortest = 0.05, longest = 10.0;  // lengths
constexpr double least_independent = 1.0e-5, most_independent = 0.5;

// t/sqrt(1 + t^2), and back; a prediction may overshoot what any t gives.
double output_of(double t) { return t / std::sqrt(1.0 + t * t); }
double residual_of(double output) {
  constexpr double largest = 0.8;
  const double y = std::clamp(output, -largest, largest);
  return y / std::sqrt(1.0 - y * y);
}

double squared_distance(const UnitPoint& a, const UnitPoint& b) {
  double sum = 0.0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

double median_size(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median(std::move(values));
}

double nearest(std::span<const UnitPoint> points, const UnitPoint& place) {
  double least = std::numeric_limits<double>::infinity();
  for (const UnitPoint& point : points) least = std::min(least, squared_distance(point, place));
  return least;
}

}  // namespace

Emulator::Emulator(const Comparison& comparison,
                   std::span<const Evaluation> evaluations,
                   const ParameterSpace& space,
                   const Emulator* before)
    : comparison_(&comparison) {
  std::vector<std::vector<double>> all;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Evaluation& evaluation : evaluations) {
    highest_ = std::max(highest_, evaluation.objective);
    std::vector<double> residuals = comparison.residuals(evaluation.runs);
    UnitPoint point = space.to_unit(evaluation.parameters);
    if (residuals.empty() || 2 * evaluation.failed > static_cast<int>(evaluation.runs.size())) {
      failures_.push_back(std::move(point));
      continue;
    }
    if (evaluation.objective < lowest) {
      lowest = evaluation.objective;
      scale_ = std::max(1.0, median_size(residuals));
    }
    points_.push_back(std::move(point));
    all.push_back(std::move(residuals));
  }
  if (points_.size() < 2) return;

  const auto n = static_cast<Eigen::Index>(all.size());
  Eigen::MatrixXd outputs(n, static_cast<Eigen::Index>(all.front().size()));
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < outputs.cols(); ++k) {
      const double z = all[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
      outputs(i, k) = output_of(z / (2.0 * scale_));
    }
  }
  learn_correlation(outputs, before ? before->correlation_place_ : UnitPoint{});
  believed_ = points_;
  const Eigen::MatrixXd inverse = invert(correlation_, points_);
  believed_inverse_ = inverse;
  // mu = (1' K^-1 Y) / (1' K^-1 1),  y(x) = mu + c(x) K^-1 (Y - mu)   (Conti and O'Hagan, eq 4)
  mean_ = inverse.colwise().sum() * outputs / inverse.sum();
  const Eigen::MatrixXd about_mean = outputs.rowwise() - mean_;
  gains_ = inverse * about_mean;
  // Sigma = (Y - mu)' K^-1 (Y - mu) / n = W' W / n with W = L^-1 (Y - mu), K = L L': a draw of
  // N(0, Sigma) is a sum of W's rows with standard normal weights / sqrt(n)
  directions_ = inverse.llt().matrixU() * about_mean / std::sqrt(static_cast<double>(n));
}

Eigen::MatrixXd Emulator::correlate(const Correlation& correlation,
                                    std::span<const UnitPoint> a,
                                    std::span<const UnitPoint> b) {
  Eigen::ArrayXXd squares = Eigen::ArrayXXd::Zero(static_cast<Eigen::Index>(a.size()),
                                                  static_cast<Eigen::Index>(b.size()));
  for (std::size_t d = 0; d < correlation.lengths.size(); ++d) {
    const double length = correlation.lengths[d];
    for (Eigen::Index j = 0; j < squares.cols(); ++j) {
      for (Eigen::Index i = 0; i < squares.rows(); ++i) {
        const double apart =
            (a[static_cast<std::size_t>(i)][d] - b[static_cast<std::size_t>(j)][d]) / length;
        squares(i, j) += apart * apart;
      }
    }
  }
  // (1 + r + r^2/3) exp(-r),  r = sqrt(5) h   (Rasmussen and Williams 2006, eq 4.17)
  const Eigen::ArrayXXd r = (5.0 * squares).sqrt();
  return (1.0 + r + r.square() / 3.0) * (-r).exp();
}

Eigen::MatrixXd Emulator::invert(const Correlation& correlation,
                                 std::span<const UnitPoint> points) {
  Eigen::MatrixXd k = correlate(correlation, points, points);
  k.diagonal().array() += correlation.independent;
  return k.llt().solve(Eigen::MatrixXd::Identity(k.rows(), k.cols()));
}

void Emulator::learn_correlation(const Eigen::MatrixXd& outputs, const UnitPoint& start) {
  const std::size_t dimension = points_.front().size();
  const Eigen::MatrixXd centred = outputs.rowwise() - outputs.colwise().mean();
  const Eigen::MatrixXd gram = centred * centred.transpose();
  const auto correlation_at = [&](const UnitPoint& unit) {
    const auto between = [](double low, double high, double share) {
      return low * std::pow(high / low, share);
    };
    Correlation correlation;
    for (std::size_t d = 0; d < dimension; ++d)
      correlation.lengths.push_back(between(shortest, longest, unit[d]));
    correlation.independent = between(least_independent, most_independent, unit[dimension]);
    return correlation;
  };
  // e_i = [K^-1 (Y - mu)]_i / [K^-1]_ii (Dubrule 1983); of its sum of squares over all outputs
  // their products G = Y Y' are enough:  sum over i of [A G A']_ii,  A = diag(1/[K^-1]_ii) K^-1 P,
  // P = I - 1 (1' K^-1) / (1' K^-1 1)
  const auto squared_errors = [&](const UnitPoint& unit) {
    const Eigen::MatrixXd inverse = invert(correlation_at(unit), points_);
    const Eigen::VectorXd sums = inverse.rowwise().sum();
    const Eigen::MatrixXd a = inverse.diagonal().cwiseInverse().asDiagonal() *
                              (inverse - sums * sums.transpose() / sums.sum());
    const double sum = (a * gram).cwiseProduct(a).sum();
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::max();
  };
  const bool is_new = start.empty();
  std::vector<UnitPoint> tries = low_discrepancy_points(is_new ? 40 : 8, dimension + 1, 1);
  if (!is_new) tries.push_back(start);
  UnitPoint best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const UnitPoint& unit : tries) {
    const double errors = squared_errors(unit);
    if (!(errors < lowest)) continue;
    lowest = errors;
    best = unit;
  }
  const OptimiserSummary finest =
      minimise([&](const UnitPoint& unit) { return std::log(squared_errors(unit) + 1.0e-300); },
               best,
               {.max_evaluations = is_new ? 60 : 25, .initial_step = is_new ? 0.1 : 0.05});
  correlation_place_ = finest.best;
  correlation_ = correlation_at(finest.best);
  const auto count = static_cast<double>(outputs.size());
  leave_one_out_error_ = std::sqrt(squared_errors(finest.best) / count);
  value_spread_ = std::sqrt(gram.trace() / count);
}

Eigen::MatrixXd Emulator::predict(std::span<const UnitPoint> places) const {
  Eigen::MatrixXd outputs = correlate(correlation_, places, points_) * gains_;
  outputs.rowwise() += mean_;
  return outputs;
}

// sqrt(1 - c K^-1 c' + (1 - c K^-1 1)^2 / (1' K^-1 1)), of the smooth part.
Eigen::VectorXd Emulator::deviations(std::span<const UnitPoint> places) const {
  const Eigen::MatrixXd c = correlate(correlation_, places, believed_);
  const Eigen::MatrixXd gain = c * believed_inverse_;
  const Eigen::ArrayXd rest = 1.0 - gain.rowwise().sum().array();
  const Eigen::ArrayXd variance =
      1.0 - gain.cwiseProduct(c).rowwise().sum().array() + rest.square() / believed_inverse_.sum();
  return variance.max(0.0).sqrt();
}

double Emulator::objective_of(const Eigen::RowVectorXd& outputs,
                              std::vector<double>& residuals) const {
  residuals.resize(static_cast<std::size_t>(outputs.size()));
  for (Eigen::Index k = 0; k < outputs.size(); ++k)
    residuals[static_cast<std::size_t>(k)] = 2.0 * scale_ * residual_of(outputs(k));
  return comparison_->loss(residuals);
}

bool Emulator::is_near_a_failure(const UnitPoint& place) const {
  return nearest(failures_, place) < nearest(points_, place);
}

std::vector<double> Emulator::objectives(std::span<const UnitPoint> places) const {
  const Eigen::MatrixXd outputs = predict(places);
  std::vector<double> objectives(places.size(), highest_);
  std::vector<double> residuals;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_near_a_failure(places[i]))
      objectives[i] = objective_of(outputs.row(static_cast<Eigen::Index>(i)), residuals);
  }
  return objectives;
}

std::vector<std::vector<double>> Emulator::draw_objectives(std::span<const UnitPoint> places,
                                                           int count,
                                                           std::uint64_t seed) const {
  const Eigen::MatrixXd outputs = predict(places);
  const Eigen::VectorXd deviation = deviations(places);
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal;
  std::vector<std::vector<double>> drawn;
  std::vector<double> residuals;
  for (int draw = 0; draw < count; ++draw) {
    Eigen::RowVectorXd weights(directions_.rows());
    for (double& weight : weights) weight = normal(generator);
    const Eigen::RowVectorXd together = weights * directions_;
    std::vector<double>& objectives = drawn.emplace_back(places.size(), highest_);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (is_near_a_failure(places[i])) continue;
      const auto row = static_cast<Eigen::Index>(i);
      objectives[i] = objective_of(outputs.row(row) + deviation(row) * together, residuals);
    }
  }
  return drawn;
}

int Emulator::evaluations_near(const UnitPoint& place, double distance) const {
  const double shortest_length =
      *std::min_element(correlation_.lengths.begin(), correlation_.lengths.end());
  const auto is_near = [&](const UnitPoint& point) {
    for (std::size_t d = 0; d < place.size(); ++d) {
      if (std::abs(point[d] - place[d]) > distance * correlation_.lengths[d] / shortest_length)
        return false;
    }
    return true;
  };
  return static_cast<int>(std::count_if(points_.begin(), points_.end(), is_near));
}

Emulator Emulator::believing(const UnitPoint& place) const {
  Emulator emulator(*this);
  emulator.believed_.push_back(place);
  emulator.believed_inverse_ = invert(correlation_, emulator.believed_);
  return emulator;
}

}  // namespace graintruth::calibrate
