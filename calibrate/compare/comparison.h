// What simulations are compared with, as the search sees it: an objective, how much of it is noise
// of the seeds, and what other replicates and seeds could have made of it. Channels of any
// observables are compared in compare/channel_comparison.h.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/simulated_run.h"
#include "datasets/experiment/experiment.h"

namespace graintruth::calibrate {

// All runs at one parameter set: scene after scene, within a scene seed after seed.
struct Evaluation {
  std::string stage;
  ParameterSet parameters;
  double time_step_fraction = 0.0;
  std::vector<SimulatedRun> runs;
  int failed = 0;          // runs that did not complete
  int retried = 0;         // runs that completed at half the time step only
  double objective = 0.0;  // of all runs together
  double seconds = 0.0;    // processor time of its simulations
};

// Counts the runs of an evaluation that failed or were retried, and their processor time.
void count_runs(Evaluation& evaluation);

// How a single run compares, for the reader of the journal.
struct RunScore {
  double objective = 0.0;
  double agreement_percent = 0.0;  // NaN where there is no such thing
};

// What seeds move the residuals of an evaluation by, of one condition that is averaged over seeds:
// an evaluation with two seeds knows it from one difference only, several together know it better.
struct SeedScatter {
  // By evaluation, then by seed: moved residuals minus residuals, as widely scattered as the mean
  // of an evaluation's runs is
  std::vector<std::vector<std::vector<double>>> displacements;
  double freedom = 0.0;  // degrees of it
};

// Infinite where seeds are too few to tell.
struct SeedNoise {
  double standard_error = std::numeric_limits<double>::infinity();
  double half_width = std::numeric_limits<double>::infinity();  // at 95 %
};

// What all evaluations together tell of chance, for the difference of any two.
struct PooledChance {
  // Relative standard deviation of the objective from one parameter set to the next beyond what
  // seeds explain.
  double roughness = 0.0;
  double cost_of_own_widths = 1.0;  // see ReplicateVariance
  // As Comparison::seed_scatter gives it; empty: every pair is judged by its own seeds
  std::vector<SeedScatter> seeds = {};
};

// Variance of the difference of two objectives that comes from the replicates, judged by half
// widths that come from the same replicates, and by those of the other replicates alone. The second
// over the first, the cost of own widths, is known badly from one pair of evaluations.
struct ReplicateVariance {
  double by_own_widths = 0.0;
  double by_widths_of_others = 0.0;
};

// So much worse than the best that nothing needs to be drawn or left out to tell. Where few numbers
// are measured the best may be 0, and a residual of one is nothing unusual: rho(1) = 0.12.
bool is_hopeless(const Evaluation& evaluation, const Evaluation& best);

class Comparison {
 public:
  virtual ~Comparison() = default;

  // Of the runs of one evaluation together; is minimised. Never NaN, whatever failed.
  virtual double objective(std::span<const SimulatedRun> runs) const = 0;
  // What the objective is a loss of: simulated minus measured, in units of what replicates know.
  // residual_count() of them in the same order for all runs; empty where most failed.
  virtual std::vector<double> residuals(std::span<const SimulatedRun> runs) const = 0;
  virtual std::size_t residual_count() const = 0;
  // The objective of runs with these residuals.
  virtual double loss(std::span<const double> residuals) const = 0;
  // Standard deviation of the objective that comes from the seeds alone: delete-one jackknife.
  virtual double noise(std::span<const SimulatedRun> runs) const = 0;
  virtual RunScore score_run(const SimulatedRun& run, std::size_t scene) const = 0;
  // Why a run that was kept cannot be compared, as "it has 3 values of tracks, but 9 are compared";
  // empty where it can.
  virtual std::string misfit(const SimulatedRun& /*run*/, std::size_t /*scene*/) const {
    return {};
  }

  // Zeros where widths do not come from replicates.
  virtual ReplicateVariance replicate_variance(const Evaluation&, const Evaluation&) const {
    return {};
  }
  // Condition by condition, of evaluations of the same seeds near the best.
  virtual std::vector<SeedScatter> seed_scatter(std::span<const Evaluation>) const { return {}; }
  // By how much the objectives of two evaluations of the same seeds must differ to be told apart at
  // 95 %, when replicates and seeds could have been others. No new simulations are run.
  virtual double half_width_of_difference(const Evaluation& first,
                                          const Evaluation& second,
                                          const PooledChance& chance) const = 0;
  // By how much other replicates could move the objective of an evaluation, at 95 %; its
  // simulations are what they are. 0 where replicates tell nothing.
  virtual double half_width_by_replicates(const Evaluation&) const { return 0.0; }
  // What other seeds could move the difference of the objectives of two evaluations of the same
  // seeds by.
  virtual SeedNoise noise_of_difference(const Evaluation&, const Evaluation&) const { return {}; }
  // By how much `evaluation` may be worse than `best`, the lowest of all, before its parameters can
  // be told from the true ones at 95 %.
  virtual double allowed_excess(const Evaluation& best,
                                const Evaluation& evaluation,
                                const PooledChance& chance) const = 0;

  // The same comparison with simulated runs in place of the filmed replicates; null where these
  // are too few to show a spread.
  virtual std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun> runs) const = 0;
  // The same replicates compared by an objective of this form; null where they do not tell what it
  // needs, or know one form only.
  virtual std::unique_ptr<Comparison> with_form(datasets::ObjectiveForm) const { return nullptr; }
  virtual datasets::ObjectiveForm form() const { return datasets::ObjectiveForm::smooth; }
};

// Jackknife standard error from n delete-one values: sqrt((n - 1)/n sum (v_i - mean)^2), Efron and
// Stein (1981).
double jackknife_error(std::span<const double> values);

}  // namespace graintruth::calibrate
