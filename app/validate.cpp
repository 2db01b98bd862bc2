// graintruth validate: how well given parameters agree with the films; nothing is tuned.
#include <fmt/format.h>

#include "app/bulk_summary.h"
#include "app/session.h"
#include "app/side_by_side.h"
#include "calibrate/bin_result_files.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/result_files.h"
#include "datasets/input_error.h"

namespace graintruth::app {

namespace {

// Films of particles that stay in the picture. Returns the exit status.
int validate_tracks(const ValidateCommand& command,
                    const calibrate::ParameterSet& parameters,
                    Session& session) {
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble(problem, journal);

  // 1. The same fraction of the time step as the calibration found, where the parameter file is its
  // result
  calibrate::ValidationResult result{.parameters = parameters};
  result.time_step_fraction =
      calibrate::load_time_step_fraction(command.parameters)
          .value_or(calibrate::largest_time_step_fraction(session.experiment()));
  // 2. The score of the mean of fresh runs
  result.score =
      calibrate::score(problem,
                       *ensemble,
                       "validation",
                       {parameters, result.time_step_fraction},
                       calibrate::make_seeds(command.common.seed, "confirmation", command.runs),
                       session.simulation_progress());
  result.context = calibrate::score_context(problem, command.runs);
  session.record().simulations_run = ensemble->simulated();
  result.warnings = session.films().warnings;
  calibrate::write_validation(session.folder(), problem, result, session.seconds());
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  session.record().options = {{"runs", std::to_string(command.runs)}};

  if (!command.common.json) {
    fmt::print(
        "Agreement {:.1f} % (Student t; ceiling {:.1f} %), {:.1f} % in the thesis's form (ceiling "
        "{:.1f} %)\n",
        result.score.student.percent,
        result.context.student_ceiling,
        result.score.thesis.percent,
        result.context.thesis_ceiling);
  }
  draw_side_by_side(session, problem, {parameters, result.time_step_fraction});
  session.finish();
  if (command.require_agreement && !(result.score.student.percent >= *command.require_agreement)) {
    fmt::print(stderr,
               "The agreement of {:.1f} % is below the required {:.1f} %.\n",
               result.score.student.percent,
               *command.require_agreement);
    return 1;
  }
  return 0;
}

// Films of particles that run out of a bin.
void validate_flow(const ValidateCommand& command,
                   const calibrate::ParameterSet& parameters,
                   Session& session) {
  const calibrate::BinProblem problem = session.bin_problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble_of_all(problem, journal);
  calibrate::BinValidationResult result{.parameters = parameters};
  result.time_step_fraction = calibrate::load_time_step_fraction(command.parameters)
                                  .value_or(calibrate::largest_time_step_fraction(problem));
  result.score = calibrate::score_bin(problem,
                                      *ensemble,
                                      {parameters, result.time_step_fraction},
                                      {.seed = command.common.seed, .runs = command.runs},
                                      [&](double) { return session.simulation_progress(); });
  result.warnings = result.score.warnings;
  session.add_film_warnings(result.warnings);
  session.record().simulations_run = ensemble->simulated();
  session.record().options = {{"runs", std::to_string(command.runs)}};
  calibrate::write_bin_validation(session.folder(), problem, result, session.seconds());
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  if (!command.common.json) fmt::print("{}", words_on(result.score));
  draw_side_by_side(session, problem, {parameters, result.time_step_fraction});
  session.finish();
}

}  // namespace

int run_validate(const ValidateCommand& command) {
  Session session("validate", command.common, command.experiment);
  const calibrate::ParameterSet bench = calibrate::bench_parameters(session.experiment());
  const calibrate::ParameterSet parameters = calibrate::load_parameters(command.parameters, bench);
  if (session.experiment().rig.bin && command.require_agreement) {
    throw datasets::InputError(fmt::format(
        "{}: what runs out of a bin has no agreement in percent; leave out --require-agreement.",
        command.experiment.string()));
  }
  session.track();
  if (!session.experiment().rig.bin) return validate_tracks(command, parameters, session);
  validate_flow(command, parameters, session);
  return 0;
}

}  // namespace graintruth::app
