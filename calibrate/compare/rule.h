// How one observable of an experiment is compared: simulated channels with those of the replicates,
// condition by condition, as residuals in units of what the replicates know.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/objective.h"
#include "calibrate/compare/simulated_run.h"
#include "calibrate/observables/channel.h"

namespace graintruth::calibrate {

// Replicates of the same settings, and the scenes that are simulated for them.
struct ComparedCondition {
  std::string name;
  std::vector<std::size_t> replicates;
  // Of the ensemble that simulates the experiment: one for every replicate in their order, each
  // from the start of its own; or one for all of them.
  std::vector<std::size_t> scenes;
  bool is_paired = false;  // the former: a replicate and its simulations stand and fall together
};

struct Layout {
  std::vector<ComparedCondition> conditions;
  std::size_t scenes = 0;

  std::size_t condition_of_scene(std::size_t scene) const;
  std::size_t seeds_of(std::size_t runs) const { return runs / scenes; }
};

// How the experiment might have been.
struct Otherwise {
  enum class Mean {
    as_it_is,
    without,  // the mean without a replicate, and without its simulations where they are paired
    moved     // the mean difference moved by what a replicate deviates from its own condition's
  };
  Mean mean = Mean::as_it_is;
  std::size_t condition = 0;  // whose mean it is
  std::size_t replicate = 0;  // of all
  double share = 0.0;         // moved: of the deviation
  // Simulations stay as they are, even those that are paired with the replicate
  bool of_replicates_alone = false;
  // Half widths from all replicates but this one
  std::optional<std::size_t> widths_without;
};

class Rule {
 public:
  virtual ~Rule() = default;

  // How replicates of one condition differ from each other: by a scatter of each condition's own,
  // or by one that is learned from all of them. Empty where a law over all conditions is compared.
  struct Repeats {
    ChannelShape shape;
    bool is_pooled = false;
  };
  virtual std::optional<Repeats> repeats() const { return std::nullopt; }

  // What is kept of the runs of one evaluation.
  struct Runs {
    virtual ~Runs() = default;
  };
  virtual std::unique_ptr<Runs> digest(std::span<const SimulatedRun> runs) const = 0;
  // Whether enough runs completed for their mean to say anything.
  virtual bool is_known(const Runs& runs) const = 0;

  // z = (simulated mean - replicate mean) / half width, for every value that can be compared; never
  // NaN. How many there are, and of what, depends on the replicates alone. `weights` counts how
  // often each run enters; empty: each once, and all as at rest where the mean says nothing.
  virtual std::vector<double> residuals(const Runs& runs,
                                        std::span<const int> weights,
                                        const Otherwise& otherwise) const = 0;
  // Numbers of residuals that form a kind: a kind counts once, however many numbers it has.
  virtual std::vector<std::size_t> kinds() const = 0;
  virtual double loss(double z) const = 0;

  // Of a single run of a scene, by its own replicate where it has one.
  virtual std::vector<double> residuals_of_run(const SimulatedRun& run,
                                               std::size_t scene) const = 0;
  // Share of all interval tests that the run passes, %; NaN where there are no such tests.
  virtual double percent_inside(const SimulatedRun& run, std::size_t scene) const = 0;

  // What the replicates of a condition say: mean and 95 % interval of the mean.
  struct Band {
    std::vector<double> mean, lower, upper;
  };
  virtual Band band(std::size_t condition) const = 0;
  // What simulations make of the same.
  virtual std::vector<double> simulated_mean(const Runs& runs, std::size_t condition) const = 0;
  // Share of the interval tests that the mean of all runs passes, %; NaN where there are none.
  virtual double percent_inside_of_mean(const Runs& runs) const = 0;

  // Whether runs that failed count, as a model in which nothing moves; else they are left out.
  virtual bool counts_failures() const = 0;
  // Whether replicates that deviate in one condition tell of the others.
  virtual bool pools_conditions() const = 0;
  // Degrees of freedom of what the replicates tell, where they are pooled.
  virtual int freedom() const = 0;
  // Replicates by which a mean may be moved: those of conditions with more than one.
  virtual std::vector<std::size_t> deviating_replicates() const = 0;
};

}  // namespace graintruth::calibrate
