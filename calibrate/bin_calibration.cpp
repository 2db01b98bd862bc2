#include "calibrate/bin_calibration.h"

namespace graintruth::calibrate {

namespace {

constexpr int alternatives = 4;  // parameter sets that show what their uncertainty does

}  // namespace

CalibrationOptions bin_options() {
  return {.budget = 60,
          .search_seeds = 1,
          .gate_seeds = 1,
          .confirmation_seeds = 3,
          .choice_candidates = 3};
}

int simulations_of_bin_confirmation(const BinProblem& problem, const CalibrationOptions& options) {
  return simulations_of_score(problem, options.confirmation_seeds, alternatives);
}

BinScore confirm_bin(const BinProblem& problem,
                     Ensemble& all,
                     const CalibrationOptions& options,
                     Search& search) {
  BinScore score;
  search.timed("confirmation", [&] {
    BinScoreOptions how{.seed = options.seed, .runs = options.confirmation_seeds};
    if (!problem.experiment.tuned.empty()) {
      for (const Evaluation& evaluation : search.compatible_evaluations(alternatives))
        how.alternatives.push_back(evaluation.parameters);
    }
    score = score_bin(
        problem, all, {search.parameters(), search.time_step_fraction()}, how, [&](double cost) {
          return search.reporter(cost);
        });
    search.count({&score.evaluation, 1});
    search.count(score.others);
  });
  return score;
}

BinCalibrationResult conclude_bin(const BinProblem& problem, SearchResult found, BinScore score) {
  BinCalibrationResult result{std::move(found), std::move(score)};
  result.objective_noise = problem.calibrated->noise(result.score.calibrated_runs);
  const std::vector<std::string>& warnings = result.score.warnings;
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  return result;
}

BinCalibrationResult calibrate_bin(const BinProblem& problem,
                                   Ensemble& searched,
                                   Ensemble& all,
                                   const CalibrationOptions& options) {
  Search search(
      problem.experiment, searched, options, simulations_of_bin_confirmation(problem, options));
  search.run();
  BinScore score = confirm_bin(problem, all, options, search);
  return conclude_bin(problem, search.finish(), std::move(score));
}

}  // namespace graintruth::calibrate
