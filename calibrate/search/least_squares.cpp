#include "calibrate/search/least_squares.h"

#include <cmath>
#include <limits>
#include <optional>
#include <unsupported/Eigen/NonLinearOptimization>

#include "calibrate/compare/hypothesis_tests.h"
#include "datasets/statistics/linear_least_squares.h"

namespace graintruth::calibrate {

namespace {

using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

// What Eigen's LevenbergMarquardt asks for.
struct Functor {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Residuals* residuals;
  Eigen::Index count;
  Eigen::VectorXd typical;  // size of each parameter where it is 0

  Eigen::Index values() const { return count; }

  // Parameters that cannot be are as bad as can be written, so that the step is taken back.
  Eigen::VectorXd at(const Eigen::VectorXd& parameters) const {
    constexpr double hopeless = 1e100;
    Eigen::VectorXd result = (*residuals)(parameters);
    if (!result.allFinite()) result.setConstant(hopeless);
    return result;
  }

  int operator()(const Eigen::VectorXd& parameters, Eigen::VectorXd& result) const {
    result = at(parameters);
    return 0;
  }

  // f' = (f(-2h) - 8 f(-h) + 8 f(h) - f(2h)) / 12h, with an error of h^4
  int df(const Eigen::VectorXd& parameters, Eigen::MatrixXd& jacobian) const {
    const double relative = std::pow(std::numeric_limits<double>::epsilon(), 0.2);
    for (Eigen::Index j = 0; j < parameters.size(); ++j) {
      const double size = parameters[j] != 0.0 ? std::abs(parameters[j]) : typical[j];
      Eigen::VectorXd moved = parameters;
      const auto value = [&](double steps) {
        moved[j] = parameters[j] + steps * relative * size;
        return at(moved);
      };
      jacobian.col(j) =
          (value(-2.0) - value(2.0) + 8.0 * (value(1.0) - value(-1.0))) / (12.0 * relative * size);
    }
    return 0;
  }
};

// The largest cosine between the residuals and a derivative: 0 at a minimum.
double largest_cosine(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals) {
  double largest = 0.0;
  for (Eigen::Index j = 0; j < jacobian.cols(); ++j) {
    const double lengths = jacobian.col(j).norm() * residuals.norm();
    if (lengths > 0.0)
      largest = std::max(largest, std::abs(jacobian.col(j).dot(residuals)) / lengths);
  }
  return largest;
}

// --- Laws that are linear in their parameters
// ---------------------------------------------------

// The residuals are  values - design p.
struct LinearLaw {
  Eigen::VectorXd values;
  Eigen::MatrixXd design;

  // Whether the residuals at these parameters are what the design says, to rounding.
  bool predicts(const Eigen::VectorXd& parameters, const Eigen::VectorXd& residuals) const {
    constexpr double roundings = 64.0;
    if (!residuals.allFinite()) return false;
    const Eigen::ArrayXd size =
        values.array().abs() + (design.cwiseAbs() * parameters.cwiseAbs()).array();
    const Eigen::ArrayXd miss = (residuals - values + design * parameters).array().abs();
    return (miss <= roundings * std::numeric_limits<double>::epsilon() * size).all();
  }
};

// The law as columns, if it is linear; none otherwise. A column is what the residuals change by for
// a step so long that the rounding of the values is little beside it, and so short that whole
// numbers stay exact.
std::optional<LinearLaw> linear_law(const Residuals& residuals, const Eigen::VectorXd& start) {
  constexpr double longer = 0x1p20;
  const Eigen::Index n = start.size();
  LinearLaw law;
  law.values = residuals(Eigen::VectorXd::Zero(n));
  if (!law.values.allFinite() || law.values.size() < n) return std::nullopt;
  law.design.resize(law.values.size(), n);
  const double largest = law.values.cwiseAbs().maxCoeff();
  Eigen::VectorXd together(n);  // a step along all parameters, in which each counts alike
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto column = [&](double step) {
      Eigen::VectorXd moved = Eigen::VectorXd::Zero(n);
      moved[j] = step;
      return Eigen::VectorXd((law.values - residuals(moved)) / step);
    };
    const double size = column(1.0).cwiseAbs().maxCoeff();
    if (!(size > 0.0) || !std::isfinite(size)) return std::nullopt;
    // A power of two, so that the law rounds as little as at a step of 1
    const double step = std::exp2(std::ceil(std::log2(longer * std::max(1.0, largest / size))));
    law.design.col(j) = column(step);
    together[j] = std::max(1.0, largest) / size;
  }
  if (!law.design.allFinite()) return std::nullopt;
  for (const Eigen::VectorXd& at : {start,
                                    Eigen::VectorXd(-start),
                                    together,
                                    Eigen::VectorXd(-0.37 * together + 1.7 * start)}) {
    if (!law.predicts(at, residuals(at))) return std::nullopt;
  }
  return law;
}

// --- Certainty
// ----------------------------------------------------------------------------------

// (J^T J)^-1 by singular values, infinite where a parameter takes part in a direction that `fit`
// does not determine; notes those directions.
Eigen::MatrixXd inverse_of_normal_matrix(const Eigen::MatrixXd& jacobian, LeastSquaresFit& fit) {
  // Derivatives are good to some ten digits: what is smaller than the largest by more than that is
  // 0. Columns are scaled to one length, which cancels in the end.
  constexpr double rank_tolerance = 1e-8;
  const Eigen::Index n = jacobian.cols();
  const Eigen::VectorXd scale =
      jacobian.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian * scale.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd& sizes = svd.singularValues();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(n, n);
  fit.undetermined.resize(n, 0);
  Eigen::VectorXd part = Eigen::VectorXd::Zero(n);  // of each parameter in what is undetermined
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd direction = scale.asDiagonal() * svd.matrixV().col(i);
    if (sizes[i] > rank_tolerance * sizes[0]) {
      inverse += direction * direction.transpose() / (sizes[i] * sizes[i]);
      continue;
    }
    part += svd.matrixV().col(i).cwiseAbs();
    Eigen::VectorXd relative =
        (direction.array() / fit.parameters.array().abs().max(1e-300)).matrix();
    fit.undetermined.conservativeResize(Eigen::NoChange, fit.undetermined.cols() + 1);
    fit.undetermined.col(fit.undetermined.cols() - 1) = relative.normalized();
  }
  for (Eigen::Index j = 0; j < n; ++j) {
    if (part[j] > std::sqrt(rank_tolerance))
      inverse(j, j) = std::numeric_limits<double>::infinity();
  }
  return inverse;
}

}  // namespace

bool LeastSquaresFit::determines(int parameter) const {
  return std::isfinite(covariance(parameter, parameter));
}

double LeastSquaresFit::standard_error(int parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

double LeastSquaresFit::half_width_95(int parameter) const {
  constexpr double normal_quantile = 1.959963984540054;
  const double factor =
      scale == ResidualScale::known ? normal_quantile : student_t_quantile(0.975, freedom);
  return factor * standard_error(parameter);
}

LeastSquaresFit fit_least_squares(const Residuals& residuals,
                                  const Eigen::VectorXd& start,
                                  ResidualScale scale) {
  LeastSquaresFit fit;
  fit.scale = scale;
  fit.parameters = start;
  Functor functor{&residuals, residuals(start).size(), start.cwiseAbs().cwiseMax(1e-8)};
  fit.freedom = static_cast<int>(functor.count - start.size());
  // 0. A law that is linear has its answer at once
  if (const auto law = linear_law(residuals, start)) {
    const std::vector<double> units(
        scale == ResidualScale::known ? static_cast<std::size_t>(functor.count) : 0, 1.0);
    const datasets::LinearFit linear =
        datasets::linear_least_squares(law->design, law->values, units);
    if (linear.is_determined && law->predicts(linear.parameters, residuals(linear.parameters))) {
      fit.parameters = linear.parameters;
      fit.sum_of_squares = linear.sum_of_squares;
      fit.covariance = linear.covariance;
      fit.undetermined.resize(start.size(), 0);
      fit.converged = true;
      return fit;
    }
  }
  // 1. Search; begun again from where it ended as long as that helps, since the damping starts anew
  double before = std::numeric_limits<double>::infinity();
  constexpr int most_restarts = 20;
  for (int restart = 0; restart < most_restarts; ++restart) {
    Eigen::LevenbergMarquardt<Functor> search(functor);
    search.parameters.ftol = search.parameters.xtol = 1e-15;
    search.parameters.maxfev = 4000;
    search.minimize(fit.parameters);
    const double now = functor.at(fit.parameters).squaredNorm();
    if (!(now < before * (1.0 - 1e-12))) break;
    before = now;
  }
  // 2. Gauss-Newton by QR to the last digits, as long as steps shrink: rounding hides in the sum of
  //    squares what the steps still see
  Eigen::MatrixXd jacobian(functor.count, start.size());
  Eigen::VectorXd values = functor.at(fit.parameters);
  functor.df(fit.parameters, jacobian);
  double last = std::numeric_limits<double>::infinity();
  double length = last;  // of the next step, relative to the parameters
  constexpr int most_steps = 30;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd change = jacobian.colPivHouseholderQr().solve(-values);
    length = (change.array() / fit.parameters.array().abs().max(1e-300)).abs().maxCoeff();
    const Eigen::VectorXd moved = fit.parameters + change;
    const Eigen::VectorXd there = functor.at(moved);
    if (!(length < last) || !(there.squaredNorm() <= values.squaredNorm() * (1.0 + 1e-9))) break;
    last = length;
    fit.parameters = moved;
    values = there;
    functor.df(fit.parameters, jacobian);
  }
  fit.sum_of_squares = values.squaredNorm();
  // 3. Certainty
  const double variance =
      scale == ResidualScale::known ? 1.0 : fit.sum_of_squares / std::max(1, fit.freedom);
  fit.covariance = variance * inverse_of_normal_matrix(jacobian, fit);
  // Where the law holds exactly the residuals are rounding, which points anywhere; but then no step
  // is left to go.
  constexpr double no_step = 1e-10;
  fit.converged =
      fit.covariance.allFinite() && (length <= no_step || largest_cosine(jacobian, values) < 1e-5);
  return fit;
}

}  // namespace graintruth::calibrate
