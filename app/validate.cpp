// graintruth validate: how well given parameters agree with the films; nothing is tuned.
#include <fmt/format.h>

#include <cmath>

#include "app/session.h"
#include "app/side_by_side.h"
#include "calibrate/result_files.h"
#include "datasets/input_error.h"

namespace graintruth::app {

namespace {

// Whether values are compared that replicates repeat.
bool gives_agreement(const calibrate::Problem& problem) {
  const std::vector<calibrate::SimulatedRun> nothing(problem.calibrated_scenes.size(),
                                                     {.status = calibrate::RunStatus::unstable});
  return !std::isnan(problem.calibrated->percent_inside(nothing));
}

}  // namespace

int run_validate(const ValidateCommand& command) {
  Session session("validate", command.common, command.experiment);
  const calibrate::ParameterSet parameters = calibrate::load_parameters(
      command.parameters, datasets::bench_parameters(session.experiment()));
  session.track();
  const calibrate::Problem problem = session.problem();
  if (command.require_agreement && !gives_agreement(problem)) {
    throw datasets::InputError(fmt::format(
        "{}: what is compared has no agreement in percent; leave out --require-agreement.",
        command.experiment.string()));
  }
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble_of_all(problem, journal);
  // 1. The same fraction of the time step as the calibration found, where the parameter file is its
  // result
  const calibrate::EvaluationPoint point{parameters,
                                         calibrate::load_time_step_fraction(command.parameters)
                                             .value_or(problem.largest_time_step_fraction())};
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
  calibrate::Validation validation{.warnings = session.films().warnings};
  calibrate::write_validation(session.folder(), problem, confirmed, session.seconds(), validation);
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  if (!command.common.json) {
    for (const std::string& line : validation.lines) fmt::print("{}\n", line);
  }
  draw_side_by_side(session, problem, point);
  session.finish();
  if (!command.require_agreement) return 0;
  const double percent = validation.agreement_percent;
  if (percent >= *command.require_agreement) return 0;
  fmt::print(stderr,
             "The agreement of {:.1f} % is below the required {:.1f} %.\n",
             percent,
             *command.require_agreement);
  return 1;
}

}  // namespace graintruth::app
