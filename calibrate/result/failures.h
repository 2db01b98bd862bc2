// What must be said of simulations that failed where parameters are only evaluated.
#pragma once

#include <span>
#include <string>

#include "calibrate/problem.h"

namespace graintruth::calibrate {

struct Failures {
  // "2 of 6 simulations failed (...)", with what the first of them says; empty where none did
  std::string sentence;
  // More than half of all, or all of a condition: what is left says nothing of the parameters
  bool are_too_many = false;
};

// `scenes` are those of the problem that the evaluation simulated.
Failures failures_of(const Problem& problem,
                     std::span<const std::size_t> scenes,
                     const Evaluation& evaluation);

}  // namespace graintruth::calibrate
