// Least squares for laws that are not linear in their parameters: Levenberg-Marquardt (MINPACK, as
// Eigen keeps it) with derivatives taken numerically, and what the fit knows of its own certainty.
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
  double sum_of_squares = 0.0;
  int freedom = 0;  // residuals less parameters
  // The residuals stand at right angles on every derivative. Parameters of a fit that has not
  // converged are where it gave up.
  bool converged = false;

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
