#include "calibrate/search/self_test.h"

#include <memory>
#include <vector>

namespace graintruth::calibrate {

std::optional<SelfTest> self_test(const Comparison& comparison,
                                  std::span<const Evaluation> design) {
  // 1. The two halves of every evaluation
  std::vector<std::unique_ptr<Comparison>> truths;
  std::vector<std::span<const SimulatedRun>> models;
  for (const Evaluation& evaluation : design) {
    if (evaluation.failed > 0) continue;
    const std::span<const SimulatedRun> runs(evaluation.runs);
    auto truth = comparison.with_replicates(runs.first(runs.size() / 2));
    if (!truth) return std::nullopt;
    truths.push_back(std::move(truth));
    models.push_back(runs.subspan(runs.size() / 2));
  }
  if (truths.size() < 2) return std::nullopt;

  // 2. Which model is nearest to each truth
  SelfTest test{.truths = static_cast<int>(truths.size())};
  for (std::size_t truth = 0; truth < truths.size(); ++truth) {
    const double own = truths[truth]->objective(models[truth]);
    bool is_lowest = true;
    for (std::size_t other = 0; other < models.size(); ++other)
      is_lowest = is_lowest && (other == truth || truths[truth]->objective(models[other]) > own);
    test.found += is_lowest ? 1 : 0;
  }
  return test;
}

}  // namespace graintruth::calibrate
