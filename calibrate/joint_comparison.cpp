#include "calibrate/joint_comparison.h"

#include <algorithm>
#include <cmath>

namespace graintruth::calibrate {

JointComparison::JointComparison(std::vector<ComparedExperiment> experiments)
    : experiments_(std::move(experiments)) {
  for (const ComparedExperiment& one : experiments_) scenes_ += one.scenes;
}

// Runs are in order of scenes, those of a scene in order of seeds.
std::span<const SimulatedRun> JointComparison::runs_of(std::span<const SimulatedRun> runs,
                                                       std::size_t i) const {
  const std::size_t seeds = runs.size() / scenes_;
  std::size_t first = 0;
  for (std::size_t before = 0; before < i; ++before) first += experiments_[before].scenes;
  return runs.subspan(first * seeds, experiments_[i].scenes * seeds);
}

Evaluation JointComparison::part_of(const Evaluation& evaluation, std::size_t i) const {
  const std::span<const SimulatedRun> runs = runs_of(evaluation.runs, i);
  Evaluation part{.stage = evaluation.stage,
                  .parameters = evaluation.parameters,
                  .time_step_fraction = evaluation.time_step_fraction,
                  .runs = {runs.begin(), runs.end()},
                  .objective = experiments_[i].comparison->objective(runs)};
  count_runs(part);
  return part;
}

std::vector<Evaluation> JointComparison::parts_of(std::span<const Evaluation> evaluations,
                                                  std::size_t i) const {
  std::vector<Evaluation> parts;
  for (const Evaluation& evaluation : evaluations) parts.push_back(part_of(evaluation, i));
  return parts;
}

double JointComparison::objective(std::span<const SimulatedRun> runs) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i)
    sum += experiments_[i].weight * experiments_[i].comparison->objective(runs_of(runs, i));
  return sum;
}

std::size_t JointComparison::residual_count() const {
  std::size_t count = 0;
  for (const ComparedExperiment& one : experiments_) count += one.comparison->residual_count();
  return count;
}

std::vector<double> JointComparison::residuals(std::span<const SimulatedRun> runs) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const std::vector<double> part = experiments_[i].comparison->residuals(runs_of(runs, i));
    if (part.empty()) return {};
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

double JointComparison::loss(std::span<const double> residuals) const {
  double sum = 0.0;
  std::size_t first = 0;
  for (const ComparedExperiment& one : experiments_) {
    const std::size_t count = one.comparison->residual_count();
    sum += one.weight * one.comparison->loss(residuals.subspan(first, count));
    first += count;
  }
  return sum;
}

double JointComparison::noise(std::span<const SimulatedRun> runs) const {
  double deviation = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const ComparedExperiment& one = experiments_[i];
    deviation = std::hypot(deviation, one.weight * one.comparison->noise(runs_of(runs, i)));
  }
  return deviation;
}

RunScore JointComparison::score_run(const SimulatedRun& run, std::size_t scene) const {
  std::size_t i = 0;
  for (; scene >= experiments_[i].scenes; ++i) scene -= experiments_[i].scenes;
  return experiments_[i].comparison->score_run(run, scene);
}

ReplicateVariance JointComparison::replicate_variance(const Evaluation& first,
                                                      const Evaluation& second) const {
  ReplicateVariance sum;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const auto& [comparison, scenes, weight] = experiments_[i];
    const ReplicateVariance one =
        comparison->replicate_variance(part_of(first, i), part_of(second, i));
    sum.by_own_widths += weight * weight * one.by_own_widths;
    sum.by_widths_of_others += weight * weight * one.by_widths_of_others;
  }
  return sum;
}

double JointComparison::half_width_of_difference(const Evaluation& first,
                                                 const Evaluation& second,
                                                 const PooledChance& chance,
                                                 const BootstrapOptions& options) const {
  double half_width = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const ComparedExperiment& one = experiments_[i];
    half_width =
        std::hypot(half_width,
                   one.weight * one.comparison->half_width_of_difference(
                                    part_of(first, i), part_of(second, i), chance, options));
  }
  return half_width;
}

// Of each experiment t S is known, and t S - D, see track_comparison.h. Together S adds up in
// squares and D as it is: sqrt(sum (w t S)^2) - sum w D.
double JointComparison::allowed_excess(const Evaluation& best,
                                       const Evaluation& evaluation,
                                       const PooledChance& chance,
                                       const BootstrapOptions& options) const {
  double half_width = 0.0, distance = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const auto& [comparison, scenes, weight] = experiments_[i];
    const Evaluation here = part_of(best, i), there = part_of(evaluation, i);
    const double own = comparison->half_width_of_difference(here, there, chance, options);
    half_width = std::hypot(half_width, weight * own);
    distance += weight * (own - comparison->allowed_excess(here, there, chance, options));
  }
  return std::max(0.0, half_width - distance);
}

std::unique_ptr<Comparison> JointComparison::with_form(datasets::ObjectiveForm form) const {
  std::vector<ComparedExperiment> others = experiments_;
  for (std::size_t i = 0; i < others.size(); ++i) {
    others[i].comparison = experiments_[i].comparison->with_form(form);
    if (!others[i].comparison) return nullptr;
  }
  return std::make_unique<JointComparison>(std::move(others));
}

}  // namespace graintruth::calibrate
