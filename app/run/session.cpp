#include "app/run/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "app/run/interrupt.h"
#include "app/run/programs.h"
#include "calibrate/result/result_files.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "reports/report.h"

namespace graintruth::app {

namespace {

std::filesystem::path folder_for(const CommonOptions& options,
                                 const datasets::Experiment& experiment) {
  return options.out.empty() ? std::filesystem::path("out") / experiment.name : options.out;
}

}  // namespace

Session::Session(const std::string& verb,
                 const CommonOptions& options,
                 const std::filesystem::path& experiment_file)
    : Session(verb,
              options,
              datasets::load_experiment(experiment_file,
                                        verb == "track" ? datasets::Purpose::tracking
                                                        : datasets::Purpose::calibration)) {}

Session::Session(const std::string& verb,
                 const CommonOptions& options,
                 datasets::Experiment experiment)
    : options_(options),
      progress_(options.quiet),
      start_(std::chrono::steady_clock::now()),
      experiment_(std::move(experiment)),
      held_(folder_for(options, experiment_), verb, options.quiet) {
  if (!options.engine.empty()) experiment_.simulator.engine = options.engine;
  record_.verb = std::move(verb);
  record_.compares = record_.verb != "track";
  // Before any film is tracked for nothing
  if (record_.verb != "track") {
    calibrate::complete_particle(experiment_);
    calibrate::require_comparable(experiment_, engine());
  }
  if (record_.verb != "track") look_at_journal();
  record_.started_at = utc_now();
  record_.jobs = threads_of(options);
  if (record_.verb != "track") executor_ = make_executor();
  catch_interrupts();
}

const calibrate::Engine& Session::engine() const {
  return calibrate::engine_named(experiment_.simulator.engine);
}

std::unique_ptr<calibrate::Executor> Session::make_executor() {
  const datasets::Execution& execution = experiment_.execution;
  const std::filesystem::path root = std::filesystem::absolute(folder().root).lexically_normal();
  // Where runs share a folder, each has its own in it
  const std::filesystem::path tasks =
      execution.folder.empty()
          ? root / "tasks"
          : execution.folder / ("graintruth-tasks-" + datasets::content_hash(root.string()));
  return calibrate::make_executor(
      options_.executor.empty() ? execution.executor : options_.executor,
      {.jobs = record_.jobs,
       .execution = execution,
       .folder = tasks,
       .program = light_program(),
       .program_version = GRAINTRUTH_VERSION,
       .say = [this](const std::string& sentence) { progress_.say(sentence); }});
}

// What an earlier run left is looked at before anything is tracked or simulated on top of it.
void Session::look_at_journal() {
  if (!std::filesystem::exists(folder().journal())) return;
  calibrate::Journal journal(folder().journal());
  for (const std::string& sentence : journal.notices()) progress_.say("Note: " + sentence);
  journal.require_sound();
}

void Session::track() {
  const auto start = std::chrono::steady_clock::now();
  films_ = track_films(experiment_, folder(), jobs(), progress_);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  record_.stages.push_back({"tracking", taken.count()});
  record_.input_hashes = films_.input_hashes;
  record_.input_hashes[experiment_.file.filename().string()] =
      datasets::file_hash(experiment_.file);
  if (const auto& annotation = experiment_.annotation; !annotation.empty())
    record_.input_hashes[annotation.filename().string()] = datasets::file_hash(annotation);
}

void Session::require_usable_tracks() const {
  if (films_.failures.empty()) return;
  throw datasets::InputError(fmt::format(
      "{}: the tracking has failed of {}; look at the overlays in {}, mend film, file or "
      "corrections, or calibrate on these tracks all the same by --use-failed-tracks.",
      experiment_.file.string(),
      fmt::join(films_.failures, ", of "),
      (folder().root / "tracks").string()));
}

Session::Measurable Session::measurable() {
  Measurable measurable{experiment_, {}, films_.seen};
  measurable.experiment.replicates.clear();
  for (calibrate::RepeatedQuantity& quantity : measurable.seen) quantity.values.clear();
  std::vector<std::string> left_out;
  for (std::size_t i = 0; i < experiment_.replicates.size(); ++i) {
    if (films_.is_smeared[i]) {
      left_out.push_back(experiment_.replicates[i].name);
      continue;
    }
    measurable.experiment.replicates.push_back(experiment_.replicates[i]);
    measurable.recordings.push_back(films_.recordings[i]);
    for (std::size_t q = 0; q < films_.seen.size(); ++q)
      measurable.seen[q].values.push_back(films_.seen[q].values[i]);
  }
  if (!left_out.empty()) {
    const std::string names = fmt::format("{}", fmt::join(left_out, ", "));
    films_.warnings.push_back(datasets::first_line(
        fmt::format("{} left out: moving particles are smeared; film with a shorter exposure.",
                    names),
        fmt::format(
            "{} left out because moving particles are smeared",
            left_out.size() == 1 ? "one film was" : fmt::format("{} films were", left_out.size())),
        "Film with a shorter exposure"));
  }
  return measurable;
}

std::vector<std::string> Session::write_measured() {
  const Measurable own = measurable();
  return calibrate::write_measured(folder(), own.experiment, own.recordings);
}

calibrate::Problem Session::problem() {
  const Measurable own = measurable();
  calibrate::Problem problem = calibrate::make_problem(own.experiment, own.recordings, engine());
  calibrate::write_measured(folder(), own.experiment, own.recordings);
  films_.warnings.insert(films_.warnings.end(), problem.warnings.begin(), problem.warnings.end());
  const std::vector<datasets::Warning> doubts =
      calibrate::foreign_replicates(problem, own.recordings, own.seen);
  films_.doubts.insert(films_.doubts.end(), doubts.begin(), doubts.end());
  return problem;
}

calibrate::EngineOptions Session::engine_options() const {
  return {.step_limit = options_.step_limit,
          .stop = is_interrupted,
          .time_limit = experiment_.simulator.time_limit,
          .scratch = folder().root / "scratch",
          .folder = std::filesystem::absolute(experiment_.file).parent_path()};
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of(
    const calibrate::Problem& problem,
    std::span<const std::size_t> scenes,
    std::shared_ptr<const calibrate::Comparison> comparison,
    calibrate::Journal& journal) {
  journal.belong_to(problem.parts);
  return std::make_unique<calibrate::Ensemble>(
      calibrate::scenes_of(problem, scenes, engine_options()),
      journal,
      std::move(comparison),
      *executor_);
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of_all(const calibrate::Problem& problem,
                                                              calibrate::Journal& journal) {
  return ensemble_of(problem, problem.every_scene(), problem.all, journal);
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of_calibrated(
    const calibrate::Problem& problem, calibrate::Journal& journal) {
  return ensemble_of(problem, problem.calibrated_scenes, problem.calibrated, journal);
}

void Session::add_film_warnings(std::vector<datasets::Warning>& warnings) const {
  warnings.insert(warnings.begin(), films_.doubts.begin(), films_.doubts.end());
  warnings.insert(warnings.end(), films_.warnings.begin(), films_.warnings.end());
}

void Session::write_record() const { write_run_record(folder(), options_, experiment_, record_); }

void Session::write_report() {
  write_record();
  datasets::remove_progress(folder());
  if (std::filesystem::exists(folder().result())) reports::write_report(folder());
}

void Session::finish() {
  write_report();
  if (!std::filesystem::exists(folder().result())) return;
  const std::string result = datasets::read_whole(folder().result());
  const auto verdict = nlohmann::ordered_json::parse(result).value(
      nlohmann::ordered_json::json_pointer("/verdict/sentence"), std::string());
  if (!options_.json) fmt::print("Verdict: {}\n", verdict);
  if (options_.json) {
    fmt::print("{}", result);
    progress_.say(fmt::format("Verdict: {}", verdict));
    progress_.say(fmt::format("Report: {}", folder().report().string()));
  } else {
    fmt::print("Report: {}\n", folder().report().string());
  }
}

calibrate::SimulationProgress Session::simulation_progress() {
  return [this](int done, int total, bool) {
    progress_.show("simulating", static_cast<double>(done) / total, "");
  };
}

double Session::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace graintruth::app
