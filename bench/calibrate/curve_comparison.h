// Simulations compared with one measured curve, point by point, where no replicate tells how
// exactly it was measured: the fit's own misfit has to.
#pragma once

#include "calibrate/compare/comparison.h"

namespace graintruth::bench {

struct CurvePoint {
  double time = 0.0;     // s
  double percent = 0.0;  // discharged
};

// Of a run, at a time; 0 where it did not complete.
double percent_at(const calibrate::SimulatedRun& run, double time);

class CurveComparison final : public calibrate::Comparison {
 public:
  // `tuned`: how many parameters are fitted to these points; there must be more points.
  CurveComparison(std::vector<CurvePoint> points, int tuned);

  const std::vector<CurvePoint>& points() const { return points_; }
  int freedom() const { return static_cast<int>(points_.size()) - tuned_; }
  // Standard deviation of a point about the curve of the best fit, percentage points:
  //   s^2 = n J / (n - p)
  double scatter(double lowest_objective) const;

  // J = mean over the points of (S - D)^2, percentage points squared; S the mean over the runs.
  double objective(std::span<const calibrate::SimulatedRun> runs) const override;
  // S - D, percentage points.
  std::vector<double> residuals(std::span<const calibrate::SimulatedRun> runs) const override;
  std::size_t residual_count() const override { return points_.size(); }
  double loss(std::span<const double> residuals) const override;
  double noise(std::span<const calibrate::SimulatedRun> runs) const override;
  calibrate::RunScore score_run(const calibrate::SimulatedRun& run,
                                std::size_t scene) const override;
  // Of the 95 % interval of a point, in its standard deviations.
  double significance() const;
  // Of the better of the two.
  double half_width_of_difference(const calibrate::Evaluation& first,
                                  const calibrate::Evaluation& second,
                                  const calibrate::PooledChance& chance) const override;
  // The joint region of all p parameters of a fit to n points whose error it has to tell itself
  // (Beale 1960):
  //   J - J_min <= J_min p/(n - p) F(0.95; p, n - p)
  double allowed_excess(const calibrate::Evaluation& best,
                        const calibrate::Evaluation& evaluation,
                        const calibrate::PooledChance& chance) const override;
  // Null: there is one curve.
  std::unique_ptr<calibrate::Comparison> with_replicates(
      std::span<const calibrate::SimulatedRun> runs) const override;

 private:
  std::vector<CurvePoint> points_;
  int tuned_;
};

}  // namespace graintruth::bench
