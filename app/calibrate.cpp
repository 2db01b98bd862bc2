// graintruth calibrate: the main job, from films to calibrated parameters and their report.
#include <fmt/format.h>

#include <cmath>

#include "app/bulk_summary.h"
#include "app/session.h"
#include "app/side_by_side.h"
#include "app/watch.h"
#include "calibrate/bin_result_files.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/joint_result_files.h"
#include "calibrate/result_files.h"
#include "datasets/joint_experiment.h"
#include "datasets/store/fingerprint.h"

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
  draw_side_by_side(session, problem, {result.parameters, result.time_step.fraction});
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
  draw_side_by_side(session, problem, {result.parameters, result.time_step.fraction});
  session.finish();
}

// In a folder of its own within that of the whole.
CommonOptions options_of_member(const CommonOptions& options,
                                const datasets::RunFolder& folder,
                                const std::string& name) {
  CommonOptions own = options;
  own.out = folder.root / name;
  return own;
}

calibrate::JointMember measured_member(Session& session, double weight) {
  session.track();
  calibrate::JointMember member{.name = session.experiment().name, .weight = weight};
  if (session.experiment().rig.bin) {
    member.bin = session.bin_problem();
    member.searched = session.scenes(*member.bin, member.bin->calibrated_films);
    member.all = session.scenes(*member.bin, every_film(*member.bin));
    member.largest_time_step_fraction = calibrate::largest_time_step_fraction(*member.bin);
  } else {
    member.tracks = session.problem();
    member.searched = member.all = {session.scene(*member.tracks)};
    member.largest_time_step_fraction = calibrate::largest_time_step_fraction(session.experiment());
  }
  return member;
}

void print_member(const calibrate::JointMember& member,
                  const calibrate::JointMemberResult& result) {
  fmt::print("{}:\n", member.name);
  if (result.tracks) {
    print_agreement(*result.tracks);
  } else {
    fmt::print("{}", words_on(result.bin->score));
  }
}

// Several experiments, one set of parameters.
void calibrate_all(const CalibrateCommand& command, const datasets::JointExperiment& joint) {
  Session whole("calibrate", command.common, joint.common);
  // 1. Each experiment tracked and measured, in a folder of its own
  std::vector<std::unique_ptr<Session>> sessions;
  std::vector<calibrate::JointMember> members;
  for (const datasets::JointPart& part : joint.parts) {
    sessions.push_back(std::make_unique<Session>(
        "calibrate",
        options_of_member(command.common, whole.folder(), part.experiment.name),
        part.experiment));
    members.push_back(measured_member(*sessions.back(), part.weight));
    for (const auto& [file, hash] : sessions.back()->record().input_hashes)
      whole.record().input_hashes[part.experiment.name + "/" + file] = hash;
  }
  whole.record().input_hashes[command.experiment.filename().string()] =
      datasets::file_hash(command.experiment);

  // 2. One search on one journal
  calibrate::Journal journal(whole.folder().journal());
  journal.belong_to(calibrate::parts_of(members));
  Watch watch(command.watch, whole, {});
  const calibrate::CalibrationOptions options =
      calibration_options(command, whole, watch, calibrate::joint_options(members));
  calibrate::JointCalibrationResult result =
      calibrate::calibrate_jointly(joint.common, members, journal, options);

  // 3. A report of each experiment, then that of all
  for (std::size_t i = 0; i < members.size(); ++i) {
    Session& session = *sessions[i];
    calibrate::JointMemberResult& own = result.members[i];
    const calibrate::EvaluationPoint found{result.parameters, result.time_step.fraction};
    if (own.tracks) {
      session.add_film_warnings(own.tracks->warnings);
      calibrate::write_calibration(
          session.folder(), *members[i].tracks, options, *own.tracks, session.seconds());
      draw_side_by_side(session, *members[i].tracks, found);
    } else {
      session.add_film_warnings(own.bin->warnings);
      calibrate::write_bin_calibration(
          session.folder(), *members[i].bin, options, *own.bin, session.seconds());
      draw_side_by_side(session, *members[i].bin, found);
    }
    session.write_report();
  }
  calibrate::write_joint_calibration(
      whole.folder(), joint.common, members, options, result, whole.seconds());
  conclude(command, options, result, result.simulated, journal, whole);
  if (!command.common.json) {
    for (std::size_t i = 0; i < members.size(); ++i) print_member(members[i], result.members[i]);
  }
  whole.finish();
}

}  // namespace

int run_calibrate(const CalibrateCommand& command) {
  if (datasets::is_joint(command.experiment)) {
    calibrate_all(command, datasets::load_joint_experiment(command.experiment));
    return 0;
  }
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
