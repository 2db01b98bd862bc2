// Every compared number as a function of the parameters, learnt from the evaluations so far: a
// Gaussian process of many outputs. An objective is a narrow valley between cliffs, of which a
// surrogate of its own sees nothing before it was there; the numbers that it is made of change
// signs on the way, and tell where to look. Used for proposals only; never for a reported score.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "calibrate/compare/comparison.h"
#include "calibrate/parameters.h"
#include "calibrate/search/surrogate.h"

namespace graintruth::calibrate {

// All outputs share one correlation over the parameters (Conti and O'Hagan 2010, section 3): Matern
// 5/2 with one length a dimension, and an independent part. These minimise the squared
// leave-one-out errors (Bachoc 2013). A residual z enters as t/sqrt(1 + t^2), t = z/2s: s is 1
// or, while everything is far off, the median |z| of the best evaluation. By how much a particle
// that has gone elsewhere is wrong would drown all others.
class Emulator {
 public:
  // Evaluations most of whose runs failed are taken for places where the objective is as high as
  // anywhere. `comparison` must outlive the emulator. An emulator of fewer evaluations says where
  // the search for lengths begins; it is not needed any more afterwards.
  Emulator(const Comparison& comparison,
           std::span<const Evaluation> evaluations,
           const ParameterSpace& space,
           const Emulator* before = nullptr);

  // Whether there is enough to learn from.
  bool knows_anything() const { return points_.size() > 1; }

  // Objectives of the predicted residuals.
  std::vector<double> objectives(std::span<const UnitPoint> places) const;
  // Objectives of `count` sets of residuals drawn from the prediction: [draw][place]. What is drawn
  // at one place goes with what is drawn at another.
  std::vector<std::vector<double>> draw_objectives(std::span<const UnitPoint> places,
                                                   int count,
                                                   std::uint64_t seed) const;

  // The same emulator once the evaluations at `place` turned out as predicted: nothing changes but
  // what is uncertain nearby ("Kriging believer", Ginsbourger et al. 2010).
  Emulator believing(const UnitPoint& place) const;

  // How many of its evaluations lie nearer to `place` than `distance` of the range along which the
  // outputs change fastest, and as much farther along the others as these are longer.
  int evaluations_near(const UnitPoint& place, double distance) const;

  // Root mean square of the leave-one-out errors, and of the deviations from the mean: how much of
  // the outputs' variation is explained.
  double leave_one_out_error() const { return leave_one_out_error_; }
  double value_spread() const { return value_spread_; }

 private:
  struct Correlation {
    std::vector<double> lengths;  // of each unit range
    double independent = 0.0;     // variance, of the smooth part's
  };
  static Eigen::MatrixXd correlate(const Correlation& correlation,
                                   std::span<const UnitPoint> a,
                                   std::span<const UnitPoint> b);
  static Eigen::MatrixXd invert(const Correlation& correlation, std::span<const UnitPoint> points);
  void learn_correlation(const Eigen::MatrixXd& outputs, const UnitPoint& start);
  Eigen::MatrixXd predict(std::span<const UnitPoint> places) const;
  Eigen::VectorXd deviations(std::span<const UnitPoint> places) const;
  double objective_of(const Eigen::RowVectorXd& outputs, std::vector<double>& residuals) const;
  bool is_near_a_failure(const UnitPoint& place) const;

  const Comparison* comparison_;
  double scale_ = 1.0;
  double highest_ = 0.0;  // objective
  Correlation correlation_;
  UnitPoint correlation_place_;  // in the cube in which it was sought
  std::vector<UnitPoint> points_;
  std::vector<UnitPoint> failures_;
  std::vector<UnitPoint> believed_;   // of points_, and what is believed
  Eigen::MatrixXd believed_inverse_;  // of the correlations of believed_
  Eigen::RowVectorXd mean_;           // of every output, by generalised least squares
  Eigen::MatrixXd gains_;             // K^-1 of the outputs about it: one row a point
  Eigen::MatrixXd directions_;        // rows in which the outputs deviate together
  double leave_one_out_error_ = 0.0;
  double value_spread_ = 0.0;
};

}  // namespace graintruth::calibrate
