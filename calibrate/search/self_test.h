// Whether a known truth is found again: told after the design, from its simulations alone, before
// more is spent.
#pragma once

#include <optional>
#include <span>

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

// Every parameter set of the design stands in for the experiment once, with one half of its seeds
// as replicates; all parameter sets are compared with it by the other half.
struct SelfTest {
  int truths = 0;  // parameter sets whose simulations all completed
  int found = 0;   // of these: those whose own objective is the lowest of all
};

// None where seeds are too few to make replicates of, or fewer than two parameter sets completed.
std::optional<SelfTest> self_test(const Comparison& comparison, std::span<const Evaluation> design);

}  // namespace graintruth::calibrate
