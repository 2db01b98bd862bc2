// graintruth calibrate: the main job, from films to calibrated parameters and their report.
#include <fmt/format.h>

#include <cmath>

#include "app/bulk_summary.h"
#include "app/session.h"
#include "app/watch.h"
#include "calibrate/bin_result_files.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/result_files.h"

namespace graintruth::app {

namespace {

// What the command asks for, on top of what a calibration of this kind does by default.
calibrate::CalibrationOptions calibration_options(const CalibrateCommand& command,
                                                  Session& session,
                                                  Watch& watch,
                                                  calibrate::CalibrationOptions options) {
  options.seed = command.common.seed;
  options.jobs = session.jobs();
  if (command.budget > 0) options.budget = command.budget;
  options.time_limit = command.time_limit;
  options.notice = [&session](const std::string& sentence) {
    session.progress().say("Note: " + sentence);
  };
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

void print_parameters(const calibrate::SearchResult& result) {
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
}

void print_agreement(const calibrate::CalibrationResult& result) {
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

// What run.json says of the search, the journal's copy, and what a person wants to read first.
void conclude(const CalibrateCommand& command,
              const calibrate::CalibrationOptions& options,
              const calibrate::SearchResult& result,
              int simulated,
              calibrate::Journal& journal,
              Session& session) {
  calibrate::write_journal_csv(session.folder().journal_csv(), journal);
  RunRecord& record = session.record();
  record.simulations_run = simulated;
  record.stages.insert(record.stages.end(), result.stages.begin(), result.stages.end());
  record.options = {{"budget", std::to_string(options.budget)},
                    {"search_seeds", std::to_string(options.search_seeds)},
                    {"confirmation_seeds", std::to_string(options.confirmation_seeds)}};
  if (command.common.json) return;
  if (!session.experiment().note.empty()) fmt::print("{}\n", session.experiment().note);
  print_parameters(result);
  for (const std::string& warning : result.warnings) fmt::print("Note: {}\n", warning);
}

// Films of particles that stay in the picture.
void calibrate_tracks(const CalibrateCommand& command, Session& session) {
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble(problem, journal);
  Watch watch(command.watch, session, calibrate::agreement_of(problem));
  calibrate::CalibrationOptions options = calibration_options(command, session, watch, {});
  options.largest_time_step_fraction = calibrate::largest_time_step_fraction(session.experiment());
  calibrate::CalibrationResult result = calibrate::calibrate(problem, *ensemble, options);
  session.add_film_warnings(result.warnings);
  calibrate::write_calibration(session.folder(), problem, options, result, session.seconds());
  conclude(command, options, result, ensemble->simulated(), journal, session);
  if (!command.common.json) print_agreement(result);
  session.finish();
}

// Films of particles that run out of a bin.
void calibrate_flow(const CalibrateCommand& command, Session& session) {
  const calibrate::BinProblem problem = session.bin_problem();
  calibrate::Journal journal(session.folder().journal());
  const auto searched = session.ensemble_of_calibrated(problem, journal);
  const auto all = session.ensemble_of_all(problem, journal);
  Watch watch(command.watch, session, {});
  calibrate::CalibrationOptions options =
      calibration_options(command, session, watch, calibrate::bin_options());
  options.largest_time_step_fraction = calibrate::largest_time_step_fraction(problem);
  calibrate::BinCalibrationResult result =
      calibrate::calibrate_bin(problem, *searched, *all, options);
  session.add_film_warnings(result.warnings);
  calibrate::write_bin_calibration(session.folder(), problem, options, result, session.seconds());
  conclude(command, options, result, searched->simulated() + all->simulated(), journal, session);
  if (!command.common.json) fmt::print("{}", words_on(result.score));
  session.finish();
}

}  // namespace

int run_calibrate(const CalibrateCommand& command) {
  Session session("calibrate", command.common, command.experiment);
  session.track();
  if (session.experiment().rig.bin) {
    calibrate_flow(command, session);
  } else {
    calibrate_tracks(command, session);
  }
  return 0;
}

}  // namespace graintruth::app
