// Several comparisons as one, for experiments whose parameters are sought together:
//
//   J = sum over experiments of w J_i
//
// Experiments share parameters and seeds but neither films nor simulations, so that what chance
// does to each adds up in squares.
#pragma once

#include "calibrate/comparison.h"

namespace graintruth::calibrate {

// One experiment of several.
struct ComparedExperiment {
  std::shared_ptr<const Comparison> comparison;
  std::size_t scenes = 1;  // of the ensemble that simulates all experiments, one after the other
  double weight = 1.0;     // w, above 0
};

class JointComparison final : public Comparison {
 public:
  // At least one. The numbers compared are those of the first, then of the second, ...
  explicit JointComparison(std::vector<ComparedExperiment> experiments);

  // The evaluation as experiment `i` alone has it: its runs, and the objective of these.
  Evaluation part_of(const Evaluation& evaluation, std::size_t i) const;

  double objective(std::span<const SimulatedRun> runs) const override;
  std::size_t residual_count() const override;
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override;
  double loss(std::span<const double> residuals) const override;
  double noise(std::span<const SimulatedRun> runs) const override;
  // By its own experiment alone, unweighted.
  RunScore score_run(const SimulatedRun& run, std::size_t scene) const override;
  ReplicateVariance replicate_variance(const Evaluation& first,
                                       const Evaluation& second) const override;
  double half_width_of_difference(const Evaluation& first,
                                  const Evaluation& second,
                                  const PooledChance& chance,
                                  const BootstrapOptions& options) const override;
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        const PooledChance& chance,
                        const BootstrapOptions& options) const override;
  // Null: no part of the runs has seeds of every experiment.
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun>) const override {
    return nullptr;
  }
  // Null where an experiment does not tell what the form needs.
  std::unique_ptr<Comparison> with_form(datasets::ObjectiveForm form) const override;
  datasets::ObjectiveForm form() const override { return experiments_[0].comparison->form(); }

 private:
  std::span<const SimulatedRun> runs_of(std::span<const SimulatedRun> runs, std::size_t i) const;
  std::vector<Evaluation> parts_of(std::span<const Evaluation> evaluations, std::size_t i) const;

  std::vector<ComparedExperiment> experiments_;
  std::size_t scenes_ = 0;  // of all
};

}  // namespace graintruth::calibrate
