// Which of a few parameter sets is best, told by the same fresh seeds for all of them.
#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include "calibrate/compare/comparison.h"
#include "calibrate/knowledge/prior.h"

namespace graintruth::calibrate {

// A rare jam, which a handful of replicates is likely to miss, rules the mean of ten runs, and
// would choose among candidates by whether it fell on them. They are compared by what they
// typically give: without the one seed, of all scenes, without which the objective is lowest.
class Choice {
 public:
  // `scenes` as in the ensemble that evaluates; both references outlive the choice.
  Choice(const Comparison& comparison, const Prior& prior, std::size_t scenes)
      : comparison_(comparison), prior_(prior), scenes_(scenes) {}

  // Typical objective plus the prior's penalty. Of two seeds or fewer, with all of them.
  double typical_total(const Evaluation& evaluation) const;
  // The lowest typical total first; equal ones in their order.
  void sort(std::vector<Evaluation>& evaluations) const;
  // Whether an evaluation is worse than the reference, of the same seeds, by no more than one
  // standard error of the difference: the rule of Breiman et al. (1984), section 3.4.3.
  bool is_as_good(const Evaluation& evaluation, const Evaluation& reference) const;

 private:
  struct Typical {
    double objective = 0.0;
    std::set<std::size_t> left_out;  // seeds
  };
  Typical typical_of(const Evaluation& evaluation) const;
  std::size_t seeds_of(const Evaluation& evaluation) const;
  double objective_without(const Evaluation& evaluation,
                           const std::set<std::size_t>& left_out) const;

  const Comparison& comparison_;
  const Prior& prior_;
  std::size_t scenes_;
};

}  // namespace graintruth::calibrate
