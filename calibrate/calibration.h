// The main job where the same particles are seen in every replicate: parameters that make simulated
// tracks agree with filmed ones.
#pragma once

#include <vector>

#include "calibrate/influence.h"
#include "calibrate/score.h"
#include "calibrate/search.h"

namespace graintruth::calibrate {

// The thesis's own four frictions (section 4.2.2), all else at the calibrated values.
struct FrictionRow {
  double friction = 0.0;
  double rms_position = 0.0;       // m, of the ensemble mean
  double single_run_spread = 0.0;  // m, standard deviation of the RMS over single runs
  double agreement_percent = 0.0;  // Student
};

// The winner once more at half the time step, with the seeds of its score.
struct HalfStepCheck {
  double objective_change = 0.0;  // at the chosen step minus at its half
  double noise = 0.0;             // standard error of that if both had seeds of their own
  double agreement_change = 0.0;  // percentage points, Student
};

// What fresh simulations say of the parameters that a search has chosen.
struct Confirmation {
  Score score;
  HalfStepCheck half_step;
  std::vector<FrictionRow> friction_rows;
};

struct CalibrationResult : SearchResult, Confirmation {
  std::vector<InfluenceRow> influence;
  ScoreContext context;
};

// Simulations that a confirmation makes.
int simulations_of_confirmation(const CalibrationOptions& options);
// As further stages of `search`, which has run.
Confirmation confirm(const Problem& problem,
                     Ensemble& ensemble,
                     const CalibrationOptions& options,
                     Search& search);
// All of it together; the evaluations in `found` are of this problem.
CalibrationResult conclude(const Problem& problem,
                           const CalibrationOptions& options,
                           SearchResult found,
                           Confirmation confirmed);

// Deterministic in the problem, the options and the ensemble's simulator; resumes by being run
// again on the same journal. Throws TooManyFailures.
CalibrationResult calibrate(const Problem& problem,
                            Ensemble& ensemble,
                            const CalibrationOptions& options);

}  // namespace graintruth::calibrate
