// graintruth calibrate: the main job, from films to calibrated parameters and their report.
#include <fmt/format.h>

#include <cmath>

#include "app/session.h"
#include "app/watch.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/result_files.h"

namespace graintruth::app {

namespace {

calibrate::CalibrationOptions calibration_options(const CalibrateCommand& command,
                                                  Session& session,
                                                  Watch& watch) {
  calibrate::CalibrationOptions options;
  options.seed = command.common.seed;
  options.jobs = session.jobs();
  if (command.budget > 0) options.budget = command.budget;
  options.time_limit = command.time_limit;
  options.largest_time_step_fraction = calibrate::largest_time_step_fraction(session.experiment());
  options.progress = [&session, &watch](const calibrate::CalibrationProgress& progress) {
    watch.show(progress);
    const std::string best =
        std::isfinite(progress.best) ? fmt::format(", objective {:.3f}", progress.best) : "";
    session.progress().show("calibrating",
                            progress.share,
                            fmt::format("{} ({}/{} evaluations{})",
                                        progress.stage,
                                        progress.evaluations,
                                        progress.budget,
                                        best));
  };
  return options;
}

void print_parameters(const calibrate::CalibrationResult& result) {
  for (const calibrate::CalibratedParameter& parameter : result.calibrated) {
    const std::string interval = parameter.interval ? fmt::format("95 % interval {:.3f} to {:.3f}",
                                                                  parameter.interval->lower,
                                                                  parameter.interval->upper)
                                                    : std::string("no interval");
    fmt::print("{:28} {:6.3f}  {}, {}\n",
               parameter.name,
               parameter.value,
               interval,
               name_of(parameter.status));
  }
  fmt::print("{:28} {:6.3f}  of the Rayleigh step, {:.3g} s\n",
             "time_step",
             result.time_step.fraction,
             result.time_step.time_step);
  fmt::print(
      "Agreement {:.1f} % (Student t; ceiling {:.1f} %, a replicate scores {:.1f} %), {:.1f} % in "
      "the thesis's form "
      "(ceiling {:.1f} %, a replicate {:.1f} %)\n",
      result.score.student.percent,
      result.context.student_ceiling,
      result.context.student_leave_one_out,
      result.score.thesis.percent,
      result.context.thesis_ceiling,
      result.context.thesis_leave_one_out);
}

}  // namespace

int run_calibrate(const CalibrateCommand& command) {
  // 1. Films to tracks
  Session session("calibrate", command.common, command.experiment);
  session.track();
  const calibrate::Problem problem = session.problem();

  // 2. Search, confirm, and say how sure
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble(problem, journal);
  Watch watch(command.watch, session, problem);
  const calibrate::CalibrationOptions options = calibration_options(command, session, watch);
  calibrate::CalibrationResult result = calibrate::calibrate(problem, *ensemble, options);
  const std::vector<std::string>& film_warnings = session.films().warnings;
  result.warnings.insert(result.warnings.end(), film_warnings.begin(), film_warnings.end());

  // 3. Result, tables and report
  session.record().simulations_run = ensemble->simulated();
  calibrate::write_calibration(session.folder(), problem, options, result, session.seconds());
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  auto& stages = session.record().stages;
  stages.insert(stages.end(), result.stages.begin(), result.stages.end());
  session.record().options = {{"budget", std::to_string(options.budget)},
                              {"search_seeds", std::to_string(options.search_seeds)},
                              {"confirmation_seeds", std::to_string(options.confirmation_seeds)}};
  if (!command.common.json) {
    if (!problem.experiment.note.empty()) fmt::print("{}\n", problem.experiment.note);
    print_parameters(result);
  }
  session.finish();
  return 0;
}

}  // namespace graintruth::app
