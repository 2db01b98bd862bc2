#include "calibrate/knowledge/rotation_test.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace graintruth::calibrate {

namespace {

// P(sum_k a_k z_k^2 >= 0), z independent standard normal, the largest |a_k| being 1 (Imhof 1961,
// Biometrika 48):
//   1/2 + 1/pi int_0^inf sin(theta(u)) / (u rho(u)) du,
//   theta = 1/2 sum atan(a_k u),  rho = prod (1 + a_k^2 u^2)^(1/4).
// With u = e^v the integrand falls as e^v to the left and at least as e^(-v/2) to the right, and
// has no pole nearer to the real axis than pi/2: the trapezoidal rule errs by e^(-pi^2/step).
double chance_above_zero(const Eigen::VectorXd& a) {
  constexpr double first = -25.0, last = 45.0, step = 0.25;
  double sum = 0.0;
  for (int i = 0; i <= static_cast<int>((last - first) / step); ++i) {
    const double u = std::exp(first + i * step);
    double theta = 0.0, rho = 1.0;
    for (const double one : a) {
      theta += 0.5 * std::atan(one * u);
      rho *= std::sqrt(std::sqrt(1.0 + one * one * u * u));
    }
    sum += std::sin(theta) / rho;
  }
  return std::clamp(0.5 + sum * step / std::numbers::pi, 0.0, 1.0);
}

}  // namespace

double rotation_test(Eigen::MatrixXd rows) {
  if (rows.rows() < 2) return 1.0;
  for (Eigen::Index column = 0; column < rows.cols(); ++column) {
    const double length = rows.col(column).norm();
    if (length > 0.0) rows.col(column) /= length;
  }
  const double own = rows.row(0).squaredNorm();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rows * rows.transpose(),
                                                              Eigen::EigenvaluesOnly);
  Eigen::VectorXd above = solver.eigenvalues().array() - own;
  const double largest = above.cwiseAbs().maxCoeff();
  // All rows are equally long in every direction, as far as numbers tell
  if (!(largest > 1e-12 * own)) return 1.0;
  above /= largest;
  return chance_above_zero(above);
}

}  // namespace graintruth::calibrate
