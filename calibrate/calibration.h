// The main job: parameters that make simulation agree with experiment, in numbered steps.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/score.h"
#include "calibrate/time_step_gate.h"
#include "calibrate/uncertainty.h"

namespace graintruth::calibrate {

struct CalibrationProgress {
  std::string_view stage;
  int evaluations = 0;  // of the search, done
  int budget = 0;
  double share = 0.0;  // of the whole calibration's expected cost that is done
  double best = 0.0;   // lowest objective so far; NaN before the first
  std::span<const Evaluation> finished = {};  // of the search, in order
};

struct CalibrationOptions {
  std::uint64_t seed = 1;
  int jobs = 1;
  int budget = 100;      // evaluations of the search: design, effects, polish, profiles
  int search_seeds = 8;  // simulations an evaluation; a single run is as noisy as a replicate
  int confirmation_seeds = 10;  // fresh runs whose mean is scored
  double largest_time_step_fraction = 0.3;
  double time_limit = 0.0;  // s of wall time after which the search ends with what it has; 0: none
  double allowed_failures = 0.3;  // share of simulations; above it the calibration gives up
  // Called after every simulation.
  std::function<void(const CalibrationProgress&)> progress;
};

enum class ParameterStatus { tuned, fixed, at_bound, not_identified };
std::string_view name_of(ParameterStatus status);

struct CalibratedParameter {
  std::string name;
  double value = 0.0;
  std::optional<Interval> interval;  // 95 %; none where fixed or not identified
  ParameterStatus status = ParameterStatus::fixed;
  double bench = 0.0;
  double lower_bound = 0.0;  // of the search
  double upper_bound = 0.0;
  double effect = 0.0;        // typical change of the objective at the worse end of the range
  double effect_noise = 0.0;  // what other replicates and seeds could explain of it
};

// The thesis's own four frictions (section 4.2.2), all else at the calibrated values.
struct FrictionRow {
  double friction = 0.0;
  double rms_position = 0.0;       // m, of the ensemble mean
  double single_run_spread = 0.0;  // m, standard deviation of the RMS over single runs
  double agreement_percent = 0.0;  // Student
};

struct StageTime {
  std::string name;
  double seconds = 0.0;
};

struct CalibrationResult {
  ParameterSet parameters;
  std::vector<CalibratedParameter> calibrated;
  TimeStepChoice time_step;
  Score score;
  ScoreContext context;
  double objective_noise = 0.0;
  std::vector<Evaluation> evaluations;  // of the search, in order
  std::string stop_reason;
  std::vector<Profile> profiles;  // of the identified parameters
  std::vector<FrictionRow> friction_rows;
  int simulations = 0;
  int failed = 0;
  std::vector<std::string> warnings;
  std::vector<StageTime> stages;
};

// Thrown when more simulations fail than allowed; what() says what to try.
struct TooManyFailures : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Deterministic in the problem, the options and the ensemble's simulator; resumes by being run
// again on the same journal.
CalibrationResult calibrate(const Problem& problem,
                            Ensemble& ensemble,
                            const CalibrationOptions& options);

}  // namespace graintruth::calibrate
