// A comparison that says nothing; tests put in what they are about.
#pragma once

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

class StubComparison : public Comparison {
 public:
  double objective(std::span<const SimulatedRun>) const override { return 0.0; }
  std::vector<double> residuals(std::span<const SimulatedRun>) const override { return {}; }
  std::size_t residual_count() const override { return 0; }
  double loss(std::span<const double>) const override { return 0.0; }
  double noise(std::span<const SimulatedRun>) const override { return 0.0; }
  RunScore score_run(const SimulatedRun&, std::size_t) const override { return {}; }
  double half_width_of_difference(const Evaluation&,
                                  const Evaluation&,
                                  const PooledChance&) const override {
    return 0.0;
  }
  double allowed_excess(const Evaluation&, const Evaluation&, const PooledChance&) const override {
    return 0.0;
  }
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun>) const override {
    return nullptr;
  }
};

}  // namespace graintruth::calibrate
