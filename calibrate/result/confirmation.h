// What fresh simulations say at given parameters: nothing was chosen by them.
#pragma once

#include <functional>

#include "calibrate/compare/step_change.h"
#include "calibrate/problem.h"

namespace graintruth::calibrate {

struct ConfirmationOptions {
  std::string stage = "confirmation";
  std::uint64_t seed = 1;
  int runs = 10;    // seeds, of every scene
  int halved = 10;  // of these at half the time step as well; 0: none
  // Parameter sets that the data cannot tell from the confirmed ones: what they predict otherwise
  // is the uncertainty of the input.
  std::vector<ParameterSet> alternatives;
};

struct Confirmed {
  EvaluationPoint point;
  Evaluation runs;                       // of every scene
  std::optional<Evaluation> halved;      // at half the time step, with the first of these seeds
  std::vector<Evaluation> alternatives;  // one seed each
  // Of `runs`, those of conditions that are calibrated on
  std::vector<SimulatedRun> calibrated_runs;
  double objective = 0.0;  // of these
  double noise = 0.0;      // of that, from the seeds

  // Both together, for counting.
  std::vector<Evaluation> others() const;
};

// `all` simulates every scene. `progress` is told of batches one after the other, with the cost of
// their simulations in units of one at the time step of `point`.
Confirmed confirm(const Problem& problem,
                  Ensemble& all,
                  const EvaluationPoint& point,
                  const ConfirmationOptions& options,
                  const std::function<SimulationProgress(double cost)>& progress);

// Simulations that confirm makes.
int simulations_of_confirmation(const Problem& problem, const ConfirmationOptions& options);

// The winner once more at half the time step, with the same seeds; none where these are too few to
// tell a change from their noise.
struct HalfStepCheck {
  StepChange objective;           // of what is calibrated on
  double agreement_change = 0.0;  // percentage points, Student; NaN where there is no agreement
};
std::optional<HalfStepCheck> half_step_of(const Problem& problem, const Confirmed& confirmed);

}  // namespace graintruth::calibrate
