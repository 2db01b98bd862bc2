// Least squares for laws that are not linear in their parameters: Levenberg-Marquardt (MINPACK, as
// Eigen keeps it) with derivatives taken numerically, and what the fit knows of its own certainty.
// Laws that are linear go to datasets/statistics/linear_least_squares.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <string>

namespace graintruth::calibrate {

// Whether residuals are in units of their own standard uncertainty, or only the fit can tell how
// large that is.
enum class ResidualScale { estimated, known };

struct LeastSquaresFit {
  Eigen::VectorXd parameters;
  // s^2 (J^T J)^-1 with s^2 = sum of squares / freedom; s^2 = 1 where the scale is known.
  Eigen::MatrixXd covariance;
  // Columns of length 1, in units of the parameters at the fit: moves along which no residual
  // changes, so that only what lies across them is determined. Empty where all parameters are;
  // otherwise the covariance of those that take part in such a move is infinite.
  Eigen::MatrixXd undetermined;
  double sum_of_squares = 0.0;
  int freedom = 0;  // residuals less parameters
  // The residuals stand at right angles on every derivative. Parameters of a fit that has not
  // converged are where it gave up.
  bool converged = false;

  bool determines(int parameter) const;
  double standard_error(int parameter) const;
  // Half the width of the 95 % interval of one parameter: Student's t where the scale is estimated,
  // 1.96 where it is known.
  double half_width_95(int parameter) const;
  ResidualScale scale = ResidualScale::estimated;
};

// `residuals` returns as many values for every parameter vector; a value that is not finite tells
// that the parameters cannot be. Needs at least as many residuals as parameters.
LeastSquaresFit fit_least_squares(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
    const Eigen::VectorXd& start,
    ResidualScale scale = ResidualScale::estimated);

}  // namespace graintruth::calibrate
