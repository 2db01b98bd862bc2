#include "datasets/statistics/linear_least_squares.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace graintruth::datasets {

namespace {

using Extended = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
using ExtendedMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// Powers of two next to one over the columns' lengths: to multiply with them rounds nothing.
Eigen::VectorXd scales_of(const Eigen::MatrixXd& design) {
  Eigen::VectorXd scales(design.cols());
  for (Eigen::Index j = 0; j < design.cols(); ++j) {
    const double length = design.col(j).stableNorm();
    scales[j] = length > 0.0 ? std::exp2(-std::round(std::log2(length))) : 1.0;
  }
  return scales;
}

// Rows in units of their uncertainties
void weigh(std::span<const double> uncertainties, ExtendedMatrix& design, Extended& values) {
  for (std::size_t i = 0; i < uncertainties.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    design.row(row) /= static_cast<long double>(uncertainties[i]);
    values[row] /= static_cast<long double>(uncertainties[i]);
  }
}

void require_usable(const Eigen::MatrixXd& design,
                    const Eigen::VectorXd& values,
                    std::span<const double> uncertainties) {
  if (design.cols() == 0 || design.rows() != values.size() || design.rows() < design.cols())
    throw std::invalid_argument("linear least squares need at least as many rows as parameters");
  if (!design.allFinite() || !values.allFinite())
    throw std::invalid_argument("linear least squares of a number that is not finite");
  if (uncertainties.empty()) return;
  if (uncertainties.size() != static_cast<std::size_t>(values.size()))
    throw std::invalid_argument("linear least squares need an uncertainty of every value, or none");
  for (const double uncertainty : uncertainties) {
    if (!(uncertainty > 0.0) || !std::isfinite(uncertainty))
      throw std::invalid_argument("linear least squares of an uncertainty that is not above 0");
  }
}

}  // namespace

double LinearFit::standard_error(int parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

LinearFit linear_least_squares(const Eigen::MatrixXd& design,
                               const Eigen::VectorXd& values,
                               std::span<const double> uncertainties) {
  require_usable(design, values, uncertainties);
  const Eigen::Index m = design.rows(), n = design.cols();
  // 1. Scale, weigh, factor: A S P = Q (R; 0)
  const Eigen::VectorXd scales = scales_of(design);
  ExtendedMatrix a = (design * scales.asDiagonal()).cast<long double>();
  Extended b = values.cast<long double>();
  weigh(uncertainties, a, b);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(m, n);
  qr.setThreshold(static_cast<double>(m) * std::numeric_limits<double>::epsilon());
  qr.compute(a.cast<double>());
  LinearFit fit;
  fit.freedom = static_cast<int>(m - n);
  fit.is_determined = qr.rank() == n;
  if (!fit.is_determined) {
    const Eigen::VectorXd scaled = qr.solve(b.cast<double>());
    fit.sum_of_squares = static_cast<double>((b - a * scaled.cast<long double>()).squaredNorm());
    fit.parameters = scales.asDiagonal() * scaled;
    fit.covariance = Eigen::MatrixXd::Constant(n, n, std::numeric_limits<double>::quiet_NaN());
    return fit;
  }
  const auto r_factor = qr.matrixR().topLeftCorner(n, n).triangularView<Eigen::Upper>();
  const auto q = qr.householderQ();

  // 2. Bjoerck's iteration on  [I A; A^T 0] (r; p) = (b; 0),  with what is missing taken in
  // extended
  //    precision, as long as corrections shrink
  Extended parameters = Extended::Zero(n), residuals = Extended::Zero(m);
  double before = std::numeric_limits<double>::infinity();
  constexpr int most_steps = 20;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd f = (b - residuals - a * parameters).cast<double>();
    const Eigen::VectorXd g = (-(a.transpose() * residuals)).cast<double>();
    const Eigen::VectorXd h =
        r_factor.transpose().solve(Eigen::VectorXd(qr.colsPermutation().transpose() * g));
    Eigen::VectorXd d = q.adjoint() * f;
    const Eigen::VectorXd change =
        qr.colsPermutation() * Eigen::VectorXd(r_factor.solve(d.head(n) - h));
    d.head(n) = h;
    const double length = change.norm();
    if (step > 1 && !(length < 0.5 * before)) break;
    before = length;
    parameters += change.cast<long double>();
    residuals += Eigen::VectorXd(q * d).cast<long double>();
  }
  fit.parameters = scales.asDiagonal() * parameters.cast<double>();
  fit.sum_of_squares = static_cast<double>((b - a * parameters).squaredNorm());

  // 3. Certainty: (A^T A)^-1 = S P R^-1 R^-T P^T S
  const Eigen::MatrixXd inverse =
      scales.asDiagonal() *
      (qr.colsPermutation() * Eigen::MatrixXd(r_factor.solve(Eigen::MatrixXd::Identity(n, n))));
  const double variance =
      uncertainties.empty() ? fit.sum_of_squares / std::max(1, fit.freedom) : 1.0;
  fit.covariance = variance * (inverse * inverse.transpose());
  return fit;
}

double StraightLine::slope_standard_error(std::size_t points) const {
  return std::sqrt(sum_of_squares / (static_cast<double>(points) - 2.0) / spread_x);
}

StraightLine straight_line(std::span<const double> x, std::span<const double> y) {
  assert(!x.empty() && x.size() == y.size());
  const auto count = static_cast<double>(x.size());
  StraightLine line;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.mean_x += x[i] / count;
    mean_y += y[i] / count;
  }
  double cross = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.spread_x += (x[i] - line.mean_x) * (x[i] - line.mean_x);
    cross += (x[i] - line.mean_x) * (y[i] - mean_y);
  }
  if (line.spread_x > 0.0) line.slope = cross / line.spread_x;
  line.intercept = mean_y - line.slope * line.mean_x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double miss = y[i] - mean_y - line.slope * (x[i] - line.mean_x);
    line.sum_of_squares += miss * miss;
    line.largest_residual = std::max(line.largest_residual, std::abs(miss));
  }
  return line;
}

}  // namespace graintruth::datasets
