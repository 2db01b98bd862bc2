// graintruth validate: how well given parameters agree with the films; nothing is tuned.
#include <fmt/format.h>

#include <cmath>

#include "app/run/session.h"
#include "app/run/side_by_side.h"
#include "calibrate/result/failures.h"
#include "calibrate/result/result_files.h"
#include "calibrate/search/search.h"
#include "datasets/store/input_error.h"

namespace graintruth::app {

namespace {

// Before anything is simulated for an agreement that never comes.
void require_agreement_exists(const datasets::Experiment& experiment) {
  if (calibrate::Observables(experiment).of_agreement() != nullptr) return;
  throw datasets::InputError(
      fmt::format("{}: what is compared has no agreement in percent, which tracks and heap_height "
                  "alone give; leave out --require-agreement.",
                  experiment.file.string()));
}

}  // namespace

int run_validate(const ValidateCommand& command) {
  Session session("validate", command.common, command.experiment);
  const calibrate::ParameterSet parameters = calibrate::load_parameters(
      command.parameters, datasets::bench_parameters(session.experiment()));
  const std::optional<double> fraction = calibrate::load_time_step_fraction(command.parameters);
  if (command.require_agreement) require_agreement_exists(session.experiment());
  session.track();
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble_of_all(problem, journal);
  // 1. The same fraction of the time step as the calibration found, where the parameter file is its
  // result
  const calibrate::EvaluationPoint point{
      parameters, fraction ? *fraction : problem.largest_time_step_fraction()};
  // 2. The score of the mean of fresh runs
  const calibrate::Confirmed confirmed =
      calibrate::confirm(problem,
                         *ensemble,
                         point,
                         {.stage = "validation",
                          .seed = command.common.seed,
                          .runs = command.runs,
                          .halved = problem.simulates_each_replicate() ? 1 : 0},
                         [&](double) { return session.simulation_progress(); });
  session.record().simulations_run = ensemble->simulated();
  session.record().options = {{"runs", std::to_string(command.runs)}};
  calibrate::Validation validation;
  session.add_film_warnings(validation.warnings);
  const calibrate::Failures failures =
      calibrate::failures_of(problem, problem.every_scene(), confirmed.runs);
  if (!failures.sentence.empty()) {
    validation.warnings.push_back(
        calibrate::words_on_failed(confirmed.runs.failed,
                                   static_cast<int>(confirmed.runs.runs.size()),
                                   failures.sentence + "."));
  }
  calibrate::write_validation(session.folder(), problem, confirmed, session.seconds(), validation);
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  if (!command.common.json) {
    for (const std::string& line : validation.lines) fmt::print("{}\n", line);
  }
  draw_side_by_side(session, problem, point);
  session.finish();
  if (failures.are_too_many) {
    throw calibrate::TooManyFailures(failures.sentence + "; the report shows the rest");
  }
  if (!command.require_agreement) return 0;
  const double percent = validation.agreement_percent;
  if (percent >= *command.require_agreement) return 0;
  if (std::isnan(percent)) {
    fmt::print(stderr,
               "There is no agreement, because most simulations failed or no interval is known; "
               "{:.1f} % are required.\n",
               *command.require_agreement);
    return 1;
  }
  fmt::print(stderr,
             "The agreement of {:.1f} % is below the required {:.1f} %.\n",
             percent,
             *command.require_agreement);
  return 1;
}

}  // namespace graintruth::app
