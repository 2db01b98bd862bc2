#include "calibrate/result/confirmation.h"

namespace graintruth::calibrate {

namespace {

std::vector<SimulatedRun> calibrated_of(const Problem& problem,
                                        const std::vector<SimulatedRun>& runs) {
  const auto seeds = static_cast<std::ptrdiff_t>(runs.size() / problem.scenes.size());
  std::vector<SimulatedRun> chosen;
  for (const std::size_t scene : problem.calibrated_scenes) {
    const auto first = runs.begin() + static_cast<std::ptrdiff_t>(scene) * seeds;
    chosen.insert(chosen.end(), first, first + seeds);
  }
  return chosen;
}

}  // namespace

std::vector<Evaluation> Confirmed::others() const {
  std::vector<Evaluation> all;
  if (halved) all.push_back(*halved);
  all.insert(all.end(), alternatives.begin(), alternatives.end());
  return all;
}

Confirmed confirm(const Problem& problem,
                  Ensemble& all,
                  const EvaluationPoint& point,
                  const ConfirmationOptions& options,
                  const std::function<SimulationProgress(double cost)>& progress) {
  Confirmed confirmed{.point = point};
  // 1. The parameters, on seeds that no choice has seen
  const auto seeds = make_seeds(options.seed, "confirmation", options.runs);
  confirmed.runs = all.evaluate(options.stage, {&point, 1}, seeds, progress(1.0)).front();
  confirmed.calibrated_runs = calibrated_of(problem, confirmed.runs.runs);
  confirmed.objective = problem.calibrated->objective(confirmed.calibrated_runs);
  confirmed.noise = problem.calibrated->noise(confirmed.calibrated_runs);
  // 2. The same at half the time step
  if (options.halved > 0) {
    EvaluationPoint finer = point;
    finer.time_step_fraction *= 0.5;
    const auto first = make_seeds(options.seed, "confirmation", options.halved);
    confirmed.halved = all.evaluate("half_step", {&finer, 1}, first, progress(2.0)).front();
  }
  // 3. What parameters that the data cannot tell from these would predict
  if (!options.alternatives.empty()) {
    std::vector<EvaluationPoint> points;
    for (const ParameterSet& parameters : options.alternatives)
      points.push_back({parameters, point.time_step_fraction});
    const auto prediction = make_seeds(options.seed, "prediction", 1);
    confirmed.alternatives = all.evaluate("prediction", points, prediction, progress(1.0));
  }
  return confirmed;
}

int simulations_of_confirmation(const Problem& problem, const ConfirmationOptions& options) {
  return static_cast<int>(problem.scenes.size()) *
         (options.runs + options.halved + static_cast<int>(options.alternatives.size()));
}

std::optional<HalfStepCheck> half_step_of(const Problem& problem, const Confirmed& confirmed) {
  if (!confirmed.halved || confirmed.halved->runs.size() != confirmed.runs.runs.size())
    return std::nullopt;
  Evaluation at{.runs = confirmed.calibrated_runs, .objective = confirmed.objective};
  Evaluation at_half{.runs = calibrated_of(problem, confirmed.halved->runs)};
  at_half.objective = problem.calibrated->objective(at_half.runs);
  return HalfStepCheck{step_change(*problem.calibrated, at, at_half),
                       problem.calibrated->percent_inside(at.runs) -
                           problem.calibrated->percent_inside(at_half.runs)};
}

}  // namespace graintruth::calibrate
