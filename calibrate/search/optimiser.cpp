#include "calibrate/search/optimiser.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <nlopt.hpp>

namespace graintruth::calibrate {

namespace {

struct Search {
  const std::function<double(const std::vector<double>&)>& objective;
  const OptimiserOptions& options;
  nlopt::opt& nlopt;
  OptimiserSummary summary;
  std::exception_ptr failure;
  double last_gain_objective = std::numeric_limits<double>::max();
  int evaluations_without_gain = 0;
  bool stalled = false;

  void watch(double value) {
    if (value < last_gain_objective - options.objective_tolerance) {
      last_gain_objective = value;
      evaluations_without_gain = 0;
    } else if (++evaluations_without_gain == options.stall_evaluations) {
      stalled = true;
      nlopt.force_stop();
    }
  }
};

// NLopt turns an exception into "nlopt failure" and may go on calling after force_stop: so nothing
// passes through it.
double call(const std::vector<double>& point, std::vector<double>&, void* data) {
  auto& search = *static_cast<Search*>(data);
  if (search.failure || search.stalled) return search.summary.objective;
  try {
    std::vector<double> inside = point;
    for (double& coordinate : inside) coordinate = std::clamp(coordinate, 0.0, 1.0);
    const double value = search.objective(inside);
    ++search.summary.evaluations;
    if (value < search.summary.objective || search.summary.best.empty()) {
      search.summary.objective = value;
      search.summary.best = inside;
    }
    search.watch(value);
    return value;
  } catch (...) {
    search.failure = std::current_exception();
    search.nlopt.force_stop();
    return search.summary.objective;
  }
}

std::string reason_of(nlopt::result result) {
  switch (result) {
    case nlopt::FTOL_REACHED:
      return "the objective no longer improves by more than its noise";
    case nlopt::XTOL_REACHED:
      return "the step fell below the tolerance";
    case nlopt::MAXEVAL_REACHED:
      return "the budget is spent";
    default:
      return "the search ended";
  }
}

}  // namespace

OptimiserSummary minimise(const std::function<double(const std::vector<double>&)>& objective,
                          const std::vector<double>& start,
                          const OptimiserOptions& options) {
  nlopt::opt nlopt(nlopt::LN_SBPLX, static_cast<unsigned>(start.size()));
  Search search{objective, options, nlopt, {}, {}};
  search.summary.objective = std::numeric_limits<double>::max();
  nlopt.set_lower_bounds(0.0);
  nlopt.set_upper_bounds(1.0);
  nlopt.set_min_objective(call, &search);
  nlopt.set_maxeval(options.max_evaluations);
  nlopt.set_xtol_abs(options.tolerance);
  nlopt.set_ftol_abs(options.objective_tolerance);
  // A first step that would leave the cube goes inwards.
  std::vector<double> steps(start.size());
  for (std::size_t i = 0; i < start.size(); ++i) {
    steps[i] = start[i] + options.initial_step > 1.0 ? -options.initial_step : options.initial_step;
  }
  nlopt.set_initial_step(steps);
  std::vector<double> point = start;
  double value = 0.0;
  try {
    search.summary.stop_reason = reason_of(nlopt.optimize(point, value));
  } catch (const nlopt::roundoff_limited&) {
    search.summary.stop_reason = "rounding forbids smaller steps";
  } catch (const nlopt::forced_stop&) {
    search.summary.stop_reason = "the last evaluations brought no gain above the objective's noise";
  }
  if (search.failure) std::rethrow_exception(search.failure);
  return search.summary;
}

}  // namespace graintruth::calibrate
