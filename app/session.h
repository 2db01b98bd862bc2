// What calibrate, track and validate begin with: the experiment read, the run folder open, the
// films tracked.
#pragma once

#include <chrono>
#include <memory>
#include <span>

#include "app/commands.h"
#include "app/films.h"
#include "app/made_folders.h"
#include "app/run_record.h"
#include "calibrate/bin_problem.h"
#include "calibrate/ensemble.h"
#include "calibrate/problem.h"

namespace graintruth::app {

class Session {
 public:
  // Throws datasets::InputError for unusable input; then no folder is left that was not there
  // before.
  Session(std::string verb,
          const CommonOptions& options,
          const std::filesystem::path& experiment_file);
  // The same of an experiment that has been read.
  Session(std::string verb, const CommonOptions& options, datasets::Experiment experiment);

  void track();
  calibrate::Problem problem() const;
  // Where particles run out of a bin; films that cannot be measured are left out, with a warning.
  calibrate::BinProblem bin_problem();
  // The embedded simulator: of the tracks, of the films of a bin.
  calibrate::Scene scene(const calibrate::Problem& problem) const;
  std::vector<calibrate::Scene> scenes(const calibrate::BinProblem& problem,
                                       std::span<const std::size_t> films) const;
  // That simulator behind the journal of this run.
  std::unique_ptr<calibrate::Ensemble> ensemble(const calibrate::Problem& problem,
                                                calibrate::Journal& journal) const;

  // The same of every film of a bin, or of those that are calibrated on.
  std::unique_ptr<calibrate::Ensemble> ensemble_of_all(const calibrate::BinProblem& problem,
                                                       calibrate::Journal& journal) const;
  std::unique_ptr<calibrate::Ensemble> ensemble_of_calibrated(const calibrate::BinProblem& problem,
                                                              calibrate::Journal& journal) const;

  // What must be said of the films goes after what is said of the calibration.
  void add_film_warnings(std::vector<std::string>& warnings) const;

  void write_record() const;  // run.json
  // Writes run.json, then makes the report where there is a result.
  void write_report();
  // That, and prints where the report lies.
  void finish();
  double seconds() const;

  const datasets::Experiment& experiment() const { return experiment_; }
  const datasets::RunFolder& folder() const { return folder_; }
  const TrackedFilms& films() const { return films_; }
  ProgressLine& progress() { return progress_; }
  // Shows how many of a batch of simulations are done.
  calibrate::SimulationProgress simulation_progress();
  RunRecord& record() { return record_; }
  int jobs() const { return record_.jobs; }
  std::uint64_t seed() const { return options_.seed; }

 private:
  std::unique_ptr<calibrate::Ensemble> ensemble_of(
      const calibrate::BinProblem& problem,
      std::span<const std::size_t> films,
      std::shared_ptr<const calibrate::BinComparison> comparison,
      calibrate::Journal& journal) const;

  CommonOptions options_;
  ProgressLine progress_;
  std::chrono::steady_clock::time_point start_;
  datasets::Experiment experiment_;
  MadeFolders made_;
  datasets::RunFolder folder_;
  RunRecord record_;
  TrackedFilms films_;
};

// Indices of all films.
std::vector<std::size_t> every_film(const calibrate::BinProblem& problem);

}  // namespace graintruth::app
