// Tracks of the same particles, filmed and simulated, compared at the same moments.
#pragma once

#include "calibrate/comparison.h"
#include "calibrate/objective.h"

namespace graintruth::calibrate {

// Replicates' mean and spread, and the half widths of the objective.
struct Target {
  Band replicates;
  datasets::Trajectories mean;  // of the replicates
  HalfWidths widths;
};

class TrackComparison final : public Comparison {
 public:
  // Replicates share their times.
  explicit TrackComparison(std::vector<datasets::Trajectories> replicates,
                           datasets::ObjectiveForm form = datasets::ObjectiveForm::smooth);

  const std::vector<datasets::Trajectories>& replicates() const { return replicates_; }
  const Target& target() const { return target_; }

  // Of the mean over completed runs; that of rest where most runs failed, because the mean of a
  // lucky few says nothing of these parameters.
  double objective(std::span<const SimulatedRun> runs) const override;
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override;
  std::size_t residual_count() const override;
  double loss(std::span<const double> residuals) const override;
  double noise(std::span<const SimulatedRun> runs) const override;
  RunScore score_run(const SimulatedRun& run, std::size_t scene) const override;
  // By the jackknife (Efron and Stein 1981). Half widths that come from the same few replicates are
  // small just where these happen to lie close together, so that they seem to vary less than they
  // do, as a mean with estimated weights does (Meier 1953).
  ReplicateVariance replicate_variance(const Evaluation& first,
                                       const Evaluation& second) const override;
  // From the replicates' part, by own widths times their cost, with n - 1 degrees of freedom, and
  // the seeds' jackknife, with m - 1.
  double half_width_of_difference(const Evaluation& first,
                                  const Evaluation& second,
                                  const PooledChance& chance,
                                  const BootstrapOptions& options) const override;
  // If `evaluation` had the true parameters, its excess over another model would be -D on average,
  // D being the excess that the other has when measured numbers lie about `evaluation` as they lie
  // about the other now, and would vary with replicates and seeds by a standard deviation S: it is
  // allowed up to t S - D (Cox's test of separate models, 1962), with the roughness of either
  // objective added to S. Where the objective is a parabola of curvature H and replicates move its
  // minimum by s, S = H s |p - p_best| and D = H (p - p_best)^2 / 2, so that |p - p_best| <= t s is
  // left.
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        const PooledChance& chance,
                        const BootstrapOptions& options) const override;
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun> runs) const override;
  std::unique_ptr<Comparison> with_form(datasets::ObjectiveForm form) const override;
  datasets::ObjectiveForm form() const override { return target_.widths.form; }

 private:
  double second_difference(const HalfWidths& widths,
                           const datasets::Trajectories& first,
                           const datasets::Trajectories& second) const;
  double distance(const Evaluation& first, const Evaluation& second) const;
  double seed_deviation(const Evaluation& first, const Evaluation& second) const;

  // What is left of the target when one replicate is.
  struct Others {
    datasets::Trajectories mean;
    HalfWidths widths;
  };
  std::vector<datasets::Trajectories> replicates_;
  Target target_;
  std::vector<Others> without_;  // each replicate
};

// The trajectories of the completed runs.
std::vector<datasets::Trajectories> completed_tracks(std::span<const SimulatedRun> runs);

// The mean track over completed runs, which is what the agreement scores; without poses where fewer
// than half of the runs completed.
datasets::Trajectories mean_of_runs(std::span<const SimulatedRun> runs);

}  // namespace graintruth::calibrate
