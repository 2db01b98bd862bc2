// Numbers of which every condition has its own, a rate through each orifice, say, and whose scatter
// between replicates is pooled over conditions: few replicates of one condition say little of it.
//
//   z = (S - D) / (s sqrt(2/n))
//
// with D and S the means over a condition's n replicates and over their simulations, which scatter
// alike, and s the standard deviation of one replicate.
#pragma once

#include "calibrate/compare/rule.h"

namespace graintruth::calibrate {

class PooledRule final : public Rule {
 public:
  // What a model gives in which nothing moves, where a replicate shows `measured`.
  using AtRest = std::function<std::vector<double>(const Channel& measured)>;

  // All replicates of one condition, averaged.
  struct Mean {
    std::vector<double> values;
    double largest = 0.0;  // of their sizes
  };
  struct Scatter {
    double standard_deviation = 0.0;  // of one replicate; relative as the shape says
    int freedom = 0;
  };

  // `channel` is the place of the observable's channel in a run; `replicates` are in the order of
  // the layout's indices.
  PooledRule(std::size_t channel,
             const ChannelShape& shape,
             AtRest at_rest,
             const Layout& layout,
             std::vector<Channel> replicates);

  const ChannelShape& shape() const { return shape_; }
  std::optional<Repeats> repeats() const override { return Repeats{shape_, true}; }
  const std::vector<Mean>& means() const { return means_; }
  const Scatter& scatter() const { return scatter_; }

  // Simulated minus measured, relative as the shape says, of every condition.
  std::vector<std::vector<double>> mean_differences(const Runs& runs,
                                                    std::span<const int> weights,
                                                    const Otherwise& otherwise) const;

  std::unique_ptr<Runs> digest(std::span<const SimulatedRun> runs) const override;
  bool is_known(const Runs&) const override { return true; }
  std::vector<double> residuals(const Runs& runs,
                                std::span<const int> weights,
                                const Otherwise& otherwise) const override;
  std::vector<std::size_t> kinds() const override { return {count_}; }
  double loss(double z) const override;
  std::vector<double> residuals_of_run(const SimulatedRun& run, std::size_t scene) const override;
  double percent_inside(const SimulatedRun&, std::size_t) const override;
  Band band(std::size_t condition) const override;
  std::vector<double> simulated_mean(const Runs& runs, std::size_t condition) const override;
  double percent_inside_of_mean(const Runs&) const override;
  bool counts_failures() const override { return true; }
  bool pools_conditions() const override { return true; }
  int freedom() const override { return scatter_.freedom; }
  std::vector<std::size_t> deviating_replicates() const override;

 private:
  struct Digest;
  Mean mean_of(std::span<const std::size_t> replicates) const;
  double deviation(double value, double mean, const Mean& of) const;
  std::vector<double> difference_of(const Channel& simulated,
                                    const std::vector<double>& measured,
                                    const Mean& mean) const;
  std::vector<double> differences_of(const SimulatedRun& run, std::size_t scene) const;
  std::vector<double> deviation_of(const Digest& digest,
                                   std::size_t replicate,
                                   std::span<const int> weights,
                                   bool of_replicates_alone) const;
  Scatter find_scatter(std::optional<std::size_t> left_out) const;

  std::size_t channel_;
  ChannelShape shape_;
  AtRest at_rest_;
  Layout layout_;
  std::vector<Channel> replicates_;
  std::vector<std::size_t> condition_of_;  // each replicate
  std::vector<Mean> means_;                // each condition
  Scatter scatter_;
  std::vector<double> scatter_without_;  // each replicate
  std::size_t count_ = 0;
};

}  // namespace graintruth::calibrate
