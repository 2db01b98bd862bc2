// What calibrate, track and validate begin with: the experiment read, the run folder open, the
// films tracked.
#pragma once

#include <chrono>
#include <memory>
#include <span>

#include "app/run/films.h"
#include "app/run/held_folder.h"
#include "app/run/run_record.h"
#include "app/verbs/commands.h"
#include "calibrate/ensemble.h"
#include "calibrate/problem.h"

namespace graintruth::app {

class Session {
 public:
  // Throws datasets::InputError for unusable input; then no folder is left that was not there
  // before.
  Session(const std::string& verb,
          const CommonOptions& options,
          const std::filesystem::path& experiment_file);
  // The same of an experiment that has been read.
  Session(const std::string& verb, const CommonOptions& options, datasets::Experiment experiment);

  void track();
  // Throws datasets::InputError that names the films of which the tracking has failed, and why.
  void require_usable_tracks() const;
  // Measured as it was recorded; recordings that cannot be measured are left out, with a warning,
  // and measured.json is written. Throws datasets::InputError where nothing can be compared.
  calibrate::Problem problem();
  // What `track` prints of the recordings: measured.json and its tables alone.
  std::vector<std::string> write_measured();
  // Simulations of the problem, behind the journal of this run: of every scene, or of those that
  // are calibrated on.
  std::unique_ptr<calibrate::Ensemble> ensemble_of_all(const calibrate::Problem& problem,
                                                       calibrate::Journal& journal);
  std::unique_ptr<calibrate::Ensemble> ensemble_of_calibrated(const calibrate::Problem& problem,
                                                              calibrate::Journal& journal);
  calibrate::Executor& executor() { return *executor_; }
  calibrate::EngineOptions engine_options() const;
  const calibrate::Engine& engine() const;

  // What must be said of the films goes after what is said of the calibration; but before all else
  // what puts a replicate in doubt.
  void add_film_warnings(std::vector<datasets::Warning>& warnings) const;

  void write_record() const;  // run.json
  // Writes run.json, then makes the report where there is a result.
  void write_report();
  // That, and prints where the report lies.
  void finish();
  double seconds() const;

  const datasets::Experiment& experiment() const { return experiment_; }
  const datasets::RunFolder& folder() const { return held_.folder(); }
  const TrackedFilms& films() const { return films_; }
  ProgressLine& progress() { return progress_; }
  // Shows how many of a batch of simulations are done.
  calibrate::SimulationProgress simulation_progress();
  RunRecord& record() { return record_; }
  int jobs() const { return record_.jobs; }
  std::uint64_t seed() const { return options_.seed; }

 private:
  // The experiment with the replicates that can be measured, their recordings, and what films tell.
  struct Measurable {
    datasets::Experiment experiment;
    std::vector<datasets::Recording> recordings;
    std::vector<calibrate::RepeatedQuantity> seen;
  };
  Measurable measurable();
  void look_at_journal();
  std::unique_ptr<calibrate::Executor> make_executor();
  std::unique_ptr<calibrate::Ensemble> ensemble_of(
      const calibrate::Problem& problem,
      std::span<const std::size_t> scenes,
      std::shared_ptr<const calibrate::Comparison> comparison,
      calibrate::Journal& journal);

  CommonOptions options_;
  ProgressLine progress_;
  std::chrono::steady_clock::time_point start_;
  datasets::Experiment experiment_;
  HeldFolder held_;
  RunRecord record_;
  TrackedFilms films_;
  std::unique_ptr<calibrate::Executor> executor_;
};

}  // namespace graintruth::app
