// The one comparison: channels of replicates with channels of simulations, over any observables,
// conditions and experiments.
//
//   J = sum over experiments of w J_e,   J_e = mean over kinds of the mean of rho(z)
//
// with z the residuals of the rules and rho their loss. Experiments share parameters and seeds but
// neither replicates nor simulations, so that what chance does to each adds up in squares.
#pragma once

#include <functional>

#include "calibrate/compare/comparison.h"
#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

// One experiment as it is compared.
struct ComparedExperiment {
  std::shared_ptr<const Observables> observables;
  Layout layout;
  std::vector<Situation> situations;  // of the replicates
  std::vector<std::vector<Channel>>
      measured;         // of the replicates: one a place among all observables
  double weight = 1.0;  // w, above 0

  RuleParts parts(datasets::ObjectiveForm form) const;
};

class ChannelComparison final : public Comparison {
 public:
  // Scenes of the ensemble are those of the first experiment, then of the second, ... Throws
  // std::invalid_argument where nothing can be compared in this form.
  explicit ChannelComparison(std::vector<ComparedExperiment> experiments,
                             datasets::ObjectiveForm form = datasets::ObjectiveForm::smooth);

  const std::vector<ComparedExperiment>& experiments() const { return experiments_; }
  // The rule of an observable of one experiment; null where it is not compared.
  const Rule* rule_of(std::string_view observable, std::size_t experiment = 0) const;
  // The evaluation as experiment `i` alone has it: its runs, and the objective of these.
  Evaluation part_of(const Evaluation& evaluation, std::size_t i) const;
  // The same comparison of that experiment alone, unweighted.
  std::shared_ptr<const ChannelComparison> alone(std::size_t i) const;
  // Without one replicate of one experiment; null where its condition would have fewer than two.
  std::unique_ptr<ChannelComparison> without_replicate(std::size_t experiment,
                                                       std::size_t replicate) const;

  // What each kind adds to J at these runs of one experiment: the mean of its rho(z). J_e is their
  // mean.
  struct Share {
    std::string kind;
    double value = 0.0;
    double weight = 1.0;
  };
  std::vector<Share> shares(std::span<const SimulatedRun> runs, std::size_t experiment = 0) const;

  // Share of the interval tests that the mean of these runs passes, %: of the first observable of
  // an experiment whose values replicates repeat. NaN where there is none.
  double percent_inside(std::span<const SimulatedRun> runs, std::size_t experiment = 0) const;

  double objective(std::span<const SimulatedRun> runs) const override;
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override;
  std::size_t residual_count() const override;
  double loss(std::span<const double> residuals) const override;
  // Delete-one jackknife with conditions as strata:
  //   var = sum over conditions of (n - 1)/n sum (v_i - mean v)^2
  double noise(std::span<const SimulatedRun> runs) const override;
  RunScore score_run(const SimulatedRun& run, std::size_t scene) const override;
  std::string misfit(const SimulatedRun& run, std::size_t scene) const override;
  // By the jackknife (Efron and Stein 1981), condition by condition; where every rule pools its
  // conditions, by moving the mean of each by what any replicate deviates from its own. Half widths
  // that come from the same few replicates are small just where these happen to lie close together,
  // so that they seem to vary less than they do, as a mean with estimated weights does (Meier
  // 1953).
  ReplicateVariance replicate_variance(const Evaluation& first,
                                       const Evaluation& second) const override;
  // Of every experiment and condition in their order; nothing of those that are paired.
  std::vector<SeedScatter> seed_scatter(std::span<const Evaluation> evaluations) const override;
  // From the replicates' part, by own widths times their cost, and the seeds': their jackknife, or
  // what is pooled of them where that has more degrees of freedom. Where replicates and their
  // simulations are paired, they are one part.
  double half_width_of_difference(const Evaluation& first,
                                  const Evaluation& second,
                                  const PooledChance& chance) const override;
  double half_width_by_replicates(const Evaluation& evaluation) const override;
  SeedNoise noise_of_difference(const Evaluation& first, const Evaluation& second) const override;
  // If `evaluation` had the true parameters, its excess over another model would be -D on average,
  // D being the excess that the other has when measured numbers lie about `evaluation` as they lie
  // about the other now, and would vary with replicates and seeds by a standard deviation S: it is
  // allowed up to t S - D (Cox's test of separate models, 1962), with the roughness of either
  // objective added to S. Where the objective is a parabola of curvature H and replicates move its
  // minimum by s, S = H s |p - p_best| and D = H (p - p_best)^2 / 2, so that |p - p_best| <= t s is
  // left.
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        const PooledChance& chance) const override;
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun> runs) const override;
  std::unique_ptr<Comparison> with_form(datasets::ObjectiveForm form) const override;
  datasets::ObjectiveForm form() const override { return form_; }

 private:
  struct ComparedRule {
    std::string name;
    std::unique_ptr<Rule> rule;
    double weight = 1.0;
  };
  // One experiment's rules, and where its runs stand.
  struct Part {
    std::vector<ComparedRule> rules;
    std::size_t first_scene = 0;
    bool pools = false;  // every rule pools its conditions
    int freedom = 0;     // then: of what replicates tell
  };
  using Digests = std::vector<std::unique_ptr<Rule::Runs>>;
  struct Weighted;  // a stratum of the replicates' part
  std::vector<ComparedRule> make_rules(const ComparedExperiment& experiment,
                                       datasets::ObjectiveForm form) const;
  std::span<const SimulatedRun> runs_of(std::span<const SimulatedRun> runs, std::size_t i) const;
  Digests digest(std::size_t i, std::span<const SimulatedRun> runs) const;
  bool is_known(std::size_t i, const Digests& runs) const;
  std::vector<double> residuals_of(std::size_t i,
                                   const Digests& runs,
                                   std::span<const int> weights,
                                   const Otherwise& otherwise) const;
  double loss_of_part(std::size_t i, std::span<const double> residuals) const;
  double objective_of(std::size_t i,
                      const Digests& runs,
                      std::span<const int> weights,
                      const Otherwise& otherwise) const;
  double second_difference(std::size_t i,
                           const Digests& near,
                           const Digests& far,
                           std::optional<std::size_t> widths_without) const;
  std::vector<Weighted> ways_of(std::size_t i) const;
  struct StratumVariance {
    ReplicateVariance variance;
    double freedom = 1.0;
  };
  std::vector<StratumVariance> replicate_variances(std::size_t i,
                                                   const Evaluation& first,
                                                   const Evaluation& second) const;
  // What the seeds, which both share, add to the variance of the difference of two objectives, of
  // each condition that is not paired.
  std::vector<VarianceComponent> seed_variances(std::size_t i,
                                                const Digests& first,
                                                const Digests& second,
                                                std::size_t runs,
                                                const PooledChance& chance) const;
  double pooled_seed_variance(std::size_t i,
                              const Digests& first,
                              const Digests& second,
                              const SeedScatter& scatter) const;
  // Of the condition in PooledChance::seeds; null where nothing was pooled.
  const SeedScatter* scatter_of(std::size_t i, std::size_t condition, const PooledChance&) const;
  double distance(std::size_t i,
                  const Digests& first,
                  const Digests& second,
                  std::size_t runs) const;
  // Runs of one condition that a jackknife leaves out one by one.
  std::vector<std::vector<std::size_t>> strata_of(std::size_t i, std::size_t runs) const;

  std::vector<ComparedExperiment> experiments_;
  datasets::ObjectiveForm form_;
  std::vector<Part> parts_;
  std::size_t scenes_ = 0;
};

}  // namespace graintruth::calibrate
