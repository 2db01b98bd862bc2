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

}  // namespace

CalibrationResult calibrate(const Problem& problem,
                            Ensemble& ensemble,
                            const CalibrationOptions& options) {
  const auto frictions = static_cast<int>(thesis_frictions.size());
  Search search(
      problem.experiment, ensemble, options, (1 + frictions) * options.confirmation_seeds);
  search.run();
  const EvaluationPoint winner{search.parameters(), search.time_step_fraction()};
  const auto seeds = make_seeds(options.seed, "confirmation", options.confirmation_seeds);

  // The score of the winner, on seeds that no choice has seen
  Score winner_score;
  search.timed("confirmation", [&] {
    winner_score = score(problem, ensemble, "confirmation", winner, seeds, search.reporter());
    search.count({&winner_score.evaluation, 1});
  });
  // The thesis's four frictions, all else at the winner's, for its figure 4.4
  std::vector<FrictionRow> rows;
  search.timed("friction series", [&] {
    std::vector<EvaluationPoint> points(thesis_frictions.size(), winner);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].parameters.friction_particle_particle = thesis_frictions[i];
    const auto evaluations = ensemble.evaluate("friction", points, seeds, search.reporter());
    search.count(evaluations);
    for (const Evaluation& evaluation : evaluations) {
      if (2 * evaluation.failed <= static_cast<int>(evaluation.runs.size()))
        rows.push_back(friction_row(problem, evaluation));
    }
  });

  CalibrationResult result{search.finish()};
  result.objective_noise = problem.comparison->noise(winner_score.evaluation.runs);
  result.score = std::move(winner_score);
  result.context = score_context(problem, options.confirmation_seeds);
  result.friction_rows = std::move(rows);
  warn_of_bad_fit(result);
  return result;
}

}  // namespace graintruth::calibrate
