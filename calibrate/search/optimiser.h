// NLopt behind one door. It minimises over the unit cube, always keeps the best point that it has
// seen itself, and says in words why it stopped.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace graintruth::calibrate {

struct OptimiserOptions {
  int max_evaluations = 30;
  double initial_step = 0.1;         // of the range of each parameter
  double tolerance = 0.01;           // of the range: a smaller step ends the search
  double objective_tolerance = 0.0;  // a smaller gain ends the search; half the objective's noise
  int stall_evaluations =
      0;  // this many without a gain above the tolerance end the search; 0: never
};

struct OptimiserSummary {
  std::string stop_reason;
  int evaluations = 0;
  std::vector<double> best;  // in the unit cube
  double objective = 0.0;
};

// Subplex search (Rowan 1990; NLopt's LN_SBPLX) from `start`. `objective` must be finite; what it
// throws is rethrown after NLopt has been left in good order.
OptimiserSummary minimise(const std::function<double(const std::vector<double>&)>& objective,
                          const std::vector<double>& start,
                          const OptimiserOptions& options);

}  // namespace graintruth::calibrate
