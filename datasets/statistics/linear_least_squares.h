// Least squares for laws that are linear in their parameters: the one place where a table is fitted
// by a straight line, a polynomial or any other sum of given columns.
#pragma once

#include <Eigen/Dense>
#include <span>

namespace graintruth::datasets {

struct LinearFit {
  Eigen::VectorXd parameters;  // one a column of the design
  // s^2 (A^T A)^-1 with s^2 = sum of squares / freedom, or s^2 = 1 where uncertainties are known.
  // NaN where the columns do not determine the parameters.
  Eigen::MatrixXd covariance;
  double sum_of_squares = 0.0;  // of the residuals, in units of their uncertainties where known
  int freedom = 0;              // rows less parameters
  // No column is a sum of the others to double precision. If false, the parameters are one of many
  // choices that fit alike.
  bool is_determined = false;

  double standard_error(int parameter) const;
};

// The parameters p that make |b - A p| least, with b = `values` and A = `design`, a column for each
// parameter. `uncertainties`: the standard uncertainty of each value, all above 0 and finite; empty
// where none is known.
//
// Columns are scaled to about one length by powers of two, so that units do not matter. They are
// factored by Householder reflections with pivots. Then parameters and residuals are improved
// together in extended precision (Bjoerck 1967, BIT 7, 257). So what is lost is only what rounding
// took from `design` itself.
//
// Throws std::invalid_argument for fewer rows than columns, for a number that is not finite, and
// for an uncertainty that is not above 0.
LinearFit linear_least_squares(const Eigen::MatrixXd& design,
                               const Eigen::VectorXd& values,
                               std::span<const double> uncertainties = {});

// The straight line y = intercept + slope x. Needs two different x.
struct StraightLine {
  double slope = 0.0, intercept = 0.0;
  double mean_x = 0.0;
  double spread_x = 0.0;          // sum of (x - mean)^2
  double sum_of_squares = 0.0;    // of the residuals
  double largest_residual = 0.0;  // in size

  double at(double x) const { return intercept + slope * x; }
  // Of the slope, from the scatter about the line; NaN with two points.
  double slope_standard_error(std::size_t points) const;
};

// By differences from the means, which is the same as linear_least_squares with a column of ones
// and loses no digits. Slope 0 where all x are equal. Needs a point, and as many x as y.
StraightLine straight_line(std::span<const double> x, std::span<const double> y);

}  // namespace graintruth::datasets
