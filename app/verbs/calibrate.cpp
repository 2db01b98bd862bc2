// graintruth calibrate: the main job, from films to calibrated parameters and their report.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/run/session.h"
#include "app/run/side_by_side.h"
#include "app/run/watch.h"
#include "calibrate/result/result_files.h"
#include "datasets/experiment/joint_experiment.h"
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

// A dash stands in place of every number that the data do not give.
std::string words_on(const calibrate::CalibratedParameter& parameter) {
  const auto end = [](double value, calibrate::EndKind kind) {
    return kind == calibrate::EndKind::found ? fmt::format("{:.3f}", value) : std::string("-");
  };
  const std::string_view status = name_of(parameter.status);
  const std::string_view known = interval_status(parameter);
  if (!parameter.interval || is_unfinished(parameter)) {
    return parameter.status == calibrate::ParameterStatus::fixed
               ? fmt::format("{:6.3f}  no interval, {}", parameter.value, status)
               : fmt::format("     -  no interval, {}; {:.3f} is used",
                             is_unfinished(parameter) ? known : status,
                             parameter.value);
  }
  const bool is_at_zero = parameter.lower_end == calibrate::EndKind::open &&
                          parameter.interval->lower <= 0.0;  // nothing lies below
  return fmt::format(
      "{:6.3f}  95 % interval {} to {}, {}{}",
      parameter.value,
      end(parameter.interval->lower, is_at_zero ? calibrate::EndKind::found : parameter.lower_end),
      end(parameter.interval->upper, parameter.upper_end),
      status,
      known == "found" || known == "not_determined" ? "" : fmt::format(", {}", known));
}

void print_parameters(const calibrate::SearchResult& result) {
  constexpr std::string_view step = "time_step";
  std::size_t longest = step.size();
  for (const calibrate::CalibratedParameter& parameter : result.calibrated)
    longest = std::max(longest, parameter.name.size());
  for (const calibrate::CalibratedParameter& parameter : result.calibrated) {
    fmt::print("{:{}} {}\n", parameter.name, longest, words_on(parameter));
  }
  fmt::print("{:{}} {:6.3f}  of the Rayleigh step, {:.3g} s\n",
             step,
             longest,
             result.time_step.fraction,
             result.time_step.time_step);
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
  if (command.common.step_limit > 0)
    record.options["step_limit"] = std::to_string(command.common.step_limit);
  record.options.insert({{"budget", std::to_string(options.budget)},
                         {"search_seeds", std::to_string(options.search_seeds)},
                         {"confirmation_seeds", std::to_string(options.confirmation_seeds)}});
  if (command.common.json) return;
  if (!session.experiment().note.empty()) fmt::print("{}\n", session.experiment().note);
  print_parameters(result);
  for (const datasets::Warning& warning : result.warnings) {
    const bool is_first = warning.kind == datasets::WarningClass::first_line;
    fmt::print("{}: {}\n", is_first ? "Warning" : "Note", warning.text);
  }
}

void print_lines(const CalibrateCommand& command, const std::vector<std::string>& lines) {
  if (command.common.json) return;
  for (const std::string& line : lines) fmt::print("{}\n", line);
}

calibrate::EvaluationPoint winner_of(const calibrate::SearchResult& result) {
  return {result.parameters, result.time_step.fraction};
}

void calibrate_one(const CalibrateCommand& command, Session& session) {
  session.track();
  if (!command.use_failed_tracks) session.require_usable_tracks();
  const calibrate::Problem problem = session.problem();
  const std::array experiments = {
      calibrate::CalibratedExperiment{session.experiment().name, &problem}};
  calibrate::Journal journal(session.folder().journal());
  journal.belong_to(problem.parts);
  Watch watch(command.watch, session, calibrate::agreement_of(*problem.calibrated));
  const calibrate::CalibrationOptions options =
      calibration_options(command, session, watch, calibrate::default_options(experiments));
  calibrate::CalibrationResult result = calibrate::calibrate(problem.experiment,
                                                             experiments,
                                                             journal,
                                                             session.executor(),
                                                             session.engine_options(),
                                                             options);
  calibrate::ExperimentResult& own = result.experiments.front();
  session.add_film_warnings(own.warnings);
  const std::vector<std::string> lines =
      calibrate::write_calibration(session.folder(), problem, options, own, session.seconds());
  conclude(command, options, own, result.simulated, journal, session);
  print_lines(command, lines);
  draw_side_by_side(session, problem, winner_of(own));
  session.finish();
}

// In a folder of its own within that of the whole.
CommonOptions options_of_part(const CommonOptions& options,
                              const datasets::RunFolder& folder,
                              const std::string& name) {
  CommonOptions own = options;
  own.out = folder.root / name;
  return own;
}

// A warning of one of several experiments.
datasets::Warning of_part(const std::string& name, datasets::Warning warning) {
  warning.text = fmt::format("{}: {}", name, warning.text);
  return warning;
}

// Several experiments, one set of parameters.
void calibrate_several(const CalibrateCommand& command, const datasets::JointExperiment& several) {
  Session whole("calibrate", command.common, several.common);
  whole.record().compares = false;
  // 1. Each experiment tracked and measured, in a folder of its own
  std::vector<std::unique_ptr<Session>> sessions;
  std::vector<calibrate::Problem> problems;
  for (const datasets::JointPart& part : several.parts) {
    sessions.push_back(std::make_unique<Session>(
        "calibrate",
        options_of_part(command.common, whole.folder(), part.experiment.name),
        part.experiment));
    sessions.back()->track();
    if (!command.use_failed_tracks) sessions.back()->require_usable_tracks();
    problems.push_back(sessions.back()->problem());
    for (const auto& [file, hash] : sessions.back()->record().input_hashes)
      whole.record().input_hashes[part.experiment.name + "/" + file] = hash;
  }
  whole.record().input_hashes[command.experiment.filename().string()] =
      datasets::file_hash(command.experiment);
  std::vector<calibrate::CalibratedExperiment> experiments;
  for (std::size_t i = 0; i < problems.size(); ++i)
    experiments.push_back({sessions[i]->experiment().name, &problems[i], several.parts[i].weight});
  // 2. One search on one journal
  calibrate::Journal journal(whole.folder().journal());
  journal.belong_to(calibrate::parts_of(experiments));
  Watch watch(command.watch, whole, {});
  const calibrate::CalibrationOptions options =
      calibration_options(command, whole, watch, calibrate::default_options(experiments));
  calibrate::CalibrationResult result = calibrate::calibrate(
      several.common, experiments, journal, whole.executor(), whole.engine_options(), options);
  // 3. A report of each experiment, then that of all
  std::vector<std::vector<std::string>> lines;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    calibrate::ExperimentResult& own = result.experiments[i];
    const datasets::Warning that_there_are_others = own.warnings.front();
    sessions[i]->add_film_warnings(own.warnings);
    lines.push_back(calibrate::write_calibration(
        sessions[i]->folder(), problems[i], options, own, sessions[i]->seconds()));
    draw_side_by_side(*sessions[i], problems[i], winner_of(result));
    sessions[i]->write_report();
    for (const datasets::Warning& warning : own.warnings) {
      if (warning != that_there_are_others)  // which here is no news
        result.warnings.push_back(of_part(experiments[i].name, warning));
    }
  }
  calibrate::write_calibration_of_several(
      whole.folder(), several.common, experiments, options, result, whole.seconds());
  conclude(command, options, result, result.simulated, journal, whole);
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (lines[i].empty()) continue;  // an experiment without scores
    print_lines(command, {experiments[i].name + ":"});
    print_lines(command, lines[i]);
  }
  whole.finish();
}

}  // namespace

int run_calibrate(const CalibrateCommand& command) {
  if (datasets::is_joint(command.experiment)) {
    calibrate_several(command, datasets::load_joint_experiment(command.experiment));
    return 0;
  }
  Session session("calibrate", command.common, command.experiment);
  calibrate_one(command, session);
  return 0;
}

}  // namespace graintruth::app
