#include "calibrate/result/failures.h"

#include <fmt/format.h>

#include <map>

namespace graintruth::calibrate {

Failures failures_of(const Problem& problem,
                     std::span<const std::size_t> scenes,
                     const Evaluation& evaluation) {
  Failures failures;
  if (evaluation.failed == 0) return failures;
  // 1. How many, and in which conditions none is left
  const std::size_t all = evaluation.runs.size(), seeds = all / scenes.size();
  std::map<std::size_t, int> completed;  // by condition
  const SimulatedRun* first = nullptr;
  for (std::size_t run = 0; run < all; ++run) {
    int& count = completed[problem.scenes[scenes[run / seeds]].condition];
    if (evaluation.runs[run].status == RunStatus::completed) {
      ++count;
    } else if (first == nullptr) {
      first = &evaluation.runs[run];
    }
  }
  failures.are_too_many = 2 * static_cast<std::size_t>(evaluation.failed) > all;
  std::string where;
  for (const auto& [condition, count] : completed) {
    if (count > 0 || completed.size() == 1) continue;
    failures.are_too_many = true;
    if (where.empty()) where = fmt::format(", all of {}", problem.conditions[condition].name);
  }
  // 2. In words
  failures.sentence = fmt::format("{} of {} simulations failed{} ({}: {})",
                                  evaluation.failed,
                                  all,
                                  where,
                                  name_of(first->status),
                                  first->message);
  return failures;
}

}  // namespace graintruth::calibrate
