#include "calibrate/calibration.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace graintruth::calibrate {

namespace {

constexpr std::array<double, 4> thesis_frictions = {0.0, 0.1, 0.2, 0.35};  // section 4.2.2

FrictionRow friction_row(const Problem& problem, const Evaluation& evaluation) {
  const Band& replicates = problem.comparison->target().replicates;
  const datasets::Trajectories measured = mean_track(replicates);
  const datasets::Trajectories simulated = mean_of_runs(evaluation.runs);
  std::vector<double> single;
  for (const auto& track : completed_tracks(evaluation.runs))
    single.push_back(rms_position(track, measured));
  double mean = 0.0;
  for (const double value : single) mean += value / static_cast<double>(single.size());
  double squares = 0.0;
  for (const double value : single) squares += (value - mean) * (value - mean);
  return {evaluation.parameters.friction_particle_particle,
          rms_position(simulated, measured),
          single.size() < 2 ? 0.0 : std::sqrt(squares / static_cast<double>(single.size() - 1)),
          agreement(replicates, simulated, Critical::student_t).percent};
}

// A model that agrees less with the replicates than they do with each other is not the answer.
void warn_of_bad_fit(CalibrationResult& result) {
  if (!(result.score.student.percent < result.context.student_leave_one_out)) return;
  result.warnings.push_back(fmt::format(
      "The parameters found agree in {:.0f} % only, less than a repeat of the experiment would "
      "({:.0f} %): the search ended in a wrong valley (raise --budget or narrow the bounds), or "
      "the model lacks something.",
      result.score.student.percent,
      result.context.student_leave_one_out));
}

void warn_of_step(CalibrationResult& result) {
  constexpr double confidence_95 = 1.96;
  const HalfStepCheck& check = result.half_step;
  if (!(std::abs(check.objective_change) > confidence_95 * check.noise)) return;
  result.warnings.push_back(
      fmt::format("At the parameters found, half the time step changes the objective by {:.3g}, "
                  "which the seeds' noise of {:.3g} does not explain: the result depends on the "
                  "time step.",
                  check.objective_change,
                  check.noise));
}

}  // namespace

int simulations_of_confirmation(const CalibrationOptions& options) {
  return (1 + 2 + static_cast<int>(thesis_frictions.size())) * options.confirmation_seeds;
}

Confirmation confirm(const Problem& problem,
                     Ensemble& ensemble,
                     const CalibrationOptions& options,
                     Search& search) {
  const EvaluationPoint winner{search.parameters(), search.time_step_fraction()};
  const auto seeds = make_seeds(options.seed, "confirmation", options.confirmation_seeds);
  Confirmation confirmed;

  // The score of the winner, on seeds that no choice has seen
  search.timed("confirmation", [&] {
    confirmed.score = score(problem, ensemble, "confirmation", winner, seeds, search.reporter());
    search.count({&confirmed.score.evaluation, 1});
  });
  // The same at half the time step
  search.timed("half the time step", [&] {
    const Score half = score(problem,
                             ensemble,
                             "half_step",
                             {winner.parameters, 0.5 * winner.time_step_fraction},
                             seeds,
                             search.reporter(2.0));
    search.count({&half.evaluation, 1});
    const Evaluation& whole = confirmed.score.evaluation;
    confirmed.half_step = {whole.objective - half.evaluation.objective,
                           std::hypot(problem.comparison->noise(whole.runs),
                                      problem.comparison->noise(half.evaluation.runs)),
                           confirmed.score.student.percent - half.student.percent};
  });
  // The thesis's four frictions, all else at the winner's, for its figure 4.4
  search.timed("friction series", [&] {
    std::vector<EvaluationPoint> points(thesis_frictions.size(), winner);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].parameters.friction_particle_particle = thesis_frictions[i];
    const auto evaluations = ensemble.evaluate("friction", points, seeds, search.reporter());
    search.count(evaluations);
    for (const Evaluation& evaluation : evaluations) {
      if (2 * evaluation.failed <= static_cast<int>(evaluation.runs.size()))
        confirmed.friction_rows.push_back(friction_row(problem, evaluation));
    }
  });
  return confirmed;
}

CalibrationResult conclude(const Problem& problem,
                           const CalibrationOptions& options,
                           SearchResult found,
                           Confirmation confirmed) {
  CalibrationResult result{std::move(found), std::move(confirmed)};
  result.objective_noise = problem.comparison->noise(result.score.evaluation.runs);
  result.context = score_context(problem, options.confirmation_seeds);
  result.influence = influence_of_each(*problem.comparison, result.evaluations);
  warn_of_bad_fit(result);
  warn_of_step(result);
  return result;
}

CalibrationResult calibrate(const Problem& problem,
                            Ensemble& ensemble,
                            const CalibrationOptions& options) {
  Search search(problem.experiment, ensemble, options, simulations_of_confirmation(options));
  search.run();
  Confirmation confirmed = confirm(problem, ensemble, options, search);
  return conclude(problem, options, search.finish(), std::move(confirmed));
}

}  // namespace graintruth::calibrate
