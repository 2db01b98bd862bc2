#include "app/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>

#include "app/bulk_summary.h"
#include "app/interrupt.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "datasets/store/fingerprint.h"
#include "reports/report.h"

namespace graintruth::app {

namespace {

std::filesystem::path folder_for(const CommonOptions& options,
                                 const datasets::Experiment& experiment) {
  return options.out.empty() ? std::filesystem::path("out") / experiment.name : options.out;
}

}  // namespace

Session::Session(std::string verb,
                 const CommonOptions& options,
                 const std::filesystem::path& experiment_file)
    : Session(verb,
              options,
              datasets::load_experiment(experiment_file,
                                        verb == "track" ? datasets::Purpose::tracking
                                                        : datasets::Purpose::calibration)) {}

Session::Session(std::string verb, const CommonOptions& options, datasets::Experiment experiment)
    : options_(options),
      progress_(options.quiet),
      start_(std::chrono::steady_clock::now()),
      experiment_(std::move(experiment)),
      made_(folder_for(options, experiment_)),
      folder_(datasets::open_run_folder(folder_for(options, experiment_))) {
  record_.verb = std::move(verb);
  // Before any film is tracked for nothing
  if (record_.verb != "track") {
    if (experiment_.rig.bin) {
      calibrate::require_plates(experiment_);
    } else {
      calibrate::require_comparable(experiment_);
    }
  }
  record_.started_at = utc_now();
  record_.jobs = threads_of(options);
  catch_interrupts();
}

void Session::track() {
  const auto start = std::chrono::steady_clock::now();
  films_ = track_films(experiment_, folder_, jobs(), progress_);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  record_.stages.push_back({"tracking", taken.count()});
  record_.input_hashes = films_.input_hashes;
  record_.input_hashes[experiment_.file.filename().string()] =
      datasets::file_hash(experiment_.file);
}

calibrate::Problem Session::problem() const {
  return calibrate::make_problem(experiment_, films_.tracks);
}

calibrate::BinProblem Session::bin_problem() {
  const BinFilms films = measurable_films(experiment_, films_, folder_);
  if (!films.left_out.empty()) {
    films_.warnings.push_back(
        fmt::format("{} left out: moving particles are smeared; film with a shorter exposure.",
                    fmt::join(films.left_out, ", ")));
  }
  write_bulk_measurements(films, folder_);
  calibrate::BinProblem problem = calibrate::make_bin_problem(films.experiment, films.records);
  films_.warnings.insert(films_.warnings.end(), problem.warnings.begin(), problem.warnings.end());
  return problem;
}

std::vector<std::size_t> every_film(const calibrate::BinProblem& problem) {
  std::vector<std::size_t> films(problem.starts.size());
  std::iota(films.begin(), films.end(), 0);
  return films;
}

calibrate::Scene Session::scene(const calibrate::Problem& problem) const {
  return {problem.hash,
          calibrate::make_dem_simulator(experiment_, problem.starts, {.stop = is_interrupted})};
}

std::vector<calibrate::Scene> Session::scenes(const calibrate::BinProblem& problem,
                                              std::span<const std::size_t> films) const {
  std::vector<calibrate::Scene> scenes;
  for (const std::size_t film : films) {
    const calibrate::BinStart& start = problem.starts[film];
    scenes.push_back({start.hash, calibrate::make_bin_simulator(start, {.stop = is_interrupted})});
  }
  return scenes;
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of_all(const calibrate::BinProblem& problem,
                                                              calibrate::Journal& journal) const {
  return ensemble_of(problem, every_film(problem), problem.all, journal);
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of_calibrated(
    const calibrate::BinProblem& problem, calibrate::Journal& journal) const {
  return ensemble_of(problem, problem.calibrated_films, problem.calibrated, journal);
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble_of(
    const calibrate::BinProblem& problem,
    std::span<const std::size_t> films,
    std::shared_ptr<const calibrate::BinComparison> comparison,
    calibrate::Journal& journal) const {
  journal.belong_to(problem.parts);
  return std::make_unique<calibrate::Ensemble>(
      scenes(problem, films), journal, std::move(comparison), jobs());
}

std::unique_ptr<calibrate::Ensemble> Session::ensemble(const calibrate::Problem& problem,
                                                       calibrate::Journal& journal) const {
  journal.belong_to(problem.parts);
  return std::make_unique<calibrate::Ensemble>(
      std::vector{scene(problem)}, journal, problem.comparison, jobs());
}

void Session::add_film_warnings(std::vector<std::string>& warnings) const {
  warnings.insert(warnings.end(), films_.warnings.begin(), films_.warnings.end());
}

void Session::write_record() const { write_run_record(folder_, options_, experiment_, record_); }

void Session::write_report() {
  write_record();
  datasets::remove_progress(folder_);
  if (std::filesystem::exists(folder_.result())) reports::write_report(folder_);
}

void Session::finish() {
  write_report();
  if (!std::filesystem::exists(folder_.result())) return;
  if (options_.json) {
    fmt::print("{}", datasets::read_whole(folder_.result()));
    progress_.say(fmt::format("Report: {}", folder_.report().string()));
  } else {
    fmt::print("Report: {}\n", folder_.report().string());
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
