#include "calibrate/search/choice.h"

#include <algorithm>
#include <limits>

namespace graintruth::calibrate {

std::size_t Choice::seeds_of(const Evaluation& evaluation) const {
  return evaluation.runs.size() / scenes_;
}

// Runs stand scene after scene, within a scene seed after seed.
double Choice::objective_without(const Evaluation& evaluation,
                                 const std::set<std::size_t>& left_out) const {
  const std::size_t seeds = seeds_of(evaluation);
  std::vector<SimulatedRun> runs;
  for (std::size_t run = 0; run < evaluation.runs.size(); ++run) {
    if (!left_out.contains(run % seeds)) runs.push_back(evaluation.runs[run]);
  }
  return comparison_.objective(runs);
}

Choice::Typical Choice::typical_of(const Evaluation& evaluation) const {
  const std::size_t seeds = seeds_of(evaluation);
  if (seeds < 3) return {evaluation.objective, {}};
  Typical typical{std::numeric_limits<double>::infinity(), {}};
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    const double objective = objective_without(evaluation, {seed});
    if (objective < typical.objective) typical = {objective, {seed}};
  }
  return typical;
}

double Choice::typical_total(const Evaluation& evaluation) const {
  return typical_of(evaluation).objective + prior_.penalty(evaluation.parameters);
}

void Choice::sort(std::vector<Evaluation>& evaluations) const {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < evaluations.size(); ++i)
    order.emplace_back(typical_total(evaluations[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<Evaluation> sorted;
  for (const auto& [total, i] : order) sorted.push_back(std::move(evaluations[i]));
  evaluations = std::move(sorted);
}

// The jackknife pairs what both have in common: they share their seeds.
bool Choice::is_as_good(const Evaluation& evaluation, const Evaluation& reference) const {
  std::set<std::size_t> left_out = typical_of(evaluation).left_out;
  left_out.merge(typical_of(reference).left_out);
  const auto worse_without = [&](const std::set<std::size_t>& without) {
    return objective_without(evaluation, without) - objective_without(reference, without);
  };
  const std::size_t seeds = seeds_of(evaluation);
  std::vector<double> jackknife;
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    if (left_out.contains(seed)) continue;
    std::set<std::size_t> without = left_out;
    without.insert(seed);
    if (without.size() < seeds) jackknife.push_back(worse_without(without));
  }
  const double penalty =
      prior_.penalty(evaluation.parameters) - prior_.penalty(reference.parameters);
  return worse_without(left_out) + penalty <= jackknife_error(jackknife);
}

}  // namespace graintruth::calibrate
