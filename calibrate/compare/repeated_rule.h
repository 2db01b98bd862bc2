// Values that every replicate repeats at the same moments: tracks of the same particles, heights, a
// force in time. Each is compared with the replicates' mean of it, in units of its own interval.
#pragma once

#include "calibrate/compare/rule.h"
#include "calibrate/compare/weighted_means.h"

namespace graintruth::calibrate {

class RepeatedRule final : public Rule {
 public:
  // Of one condition: replicates' mean and spread, and half widths of the residuals.
  struct Target {
    std::vector<Spread> spreads;
    std::vector<double> mean;
    std::vector<double> half_widths;
  };

  // `channel` is the place of the observable's channel in a run; `replicates` are in the order of
  // the layout's indices. `lacking` is what counts where a simulation has no value; empty: what was
  // measured at the first moment, as if nothing had moved.
  RepeatedRule(std::size_t channel,
               const ChannelShape& shape,
               datasets::ObjectiveForm form,
               const Layout& layout,
               std::vector<Channel> replicates,
               std::vector<double> lacking = {});

  const ChannelShape& shape() const { return shape_; }
  std::optional<Repeats> repeats() const override { return Repeats{shape_, false}; }
  const Target& target(std::size_t condition) const { return targets_[condition].whole; }
  // The channels of a condition's replicates.
  std::vector<const Channel*> replicates_of(std::size_t condition) const;

  std::unique_ptr<Runs> digest(std::span<const SimulatedRun> runs) const override;
  bool is_known(const Runs& runs) const override;
  std::vector<double> residuals(const Runs& runs,
                                std::span<const int> weights,
                                const Otherwise& otherwise) const override;
  std::vector<std::size_t> kinds() const override { return {count_}; }
  double loss(double z) const override { return loss_of(form_, z); }
  std::vector<double> residuals_of_run(const SimulatedRun& run, std::size_t scene) const override;
  double percent_inside(const SimulatedRun& run, std::size_t scene) const override;
  Band band(std::size_t condition) const override;
  std::vector<double> simulated_mean(const Runs& runs, std::size_t condition) const override;
  double percent_inside_of_mean(const Runs& runs) const override;
  bool counts_failures() const override { return false; }
  bool pools_conditions() const override { return false; }
  int freedom() const override { return 0; }
  std::vector<std::size_t> deviating_replicates() const override { return {}; }

 private:
  struct Digest;
  struct Others {  // what is left of a target when one replicate is
    std::vector<double> mean;
    std::vector<double> half_widths;
  };
  struct Condition {
    Target whole;
    std::vector<Others> without;  // each replicate
  };
  std::vector<double> half_widths_of(std::span<const Channel* const> replicates,
                                     int left_out) const;
  void append_residuals(const std::vector<double>& measured,
                        const std::vector<double>& half_widths,
                        const std::vector<double>& simulated,
                        std::vector<double>& all) const;

  std::size_t channel_;
  ChannelShape shape_;
  datasets::ObjectiveForm form_;
  Layout layout_;
  std::vector<Channel> replicates_;
  std::vector<double> lacking_;
  std::vector<Condition> targets_;
  std::size_t count_ = 0;  // residuals of all conditions
};

}  // namespace graintruth::calibrate
