// Twins: experiments made by the simulator itself, so that their truth is known. For studies of the
// calibration; nothing here is used by the program.
#pragma once

#include <filesystem>

#include "calibrate/calibration.h"

namespace graintruth::bench {

struct Twin {
  calibrate::ParameterSet truth;
  std::vector<datasets::Recording> recordings;  // of the replicates
  calibrate::Problem problem;
};

// The micro rig, its particles softened so that a run costs a tenth: E = 5e7 Pa, as the synthetic
// films'.
datasets::Experiment softened_micro_rig();
inline constexpr double softened_modulus = 5.0e7;  // Pa

// Twin number `number`: a truth drawn uniformly over the full bounds of the experiment, and five
// replicates that a steady hand placed (0.3 mm, 0.6 deg) and a good camera tracked (0.1 mm,
// 0.2 deg). The same for the same arguments.
Twin make_twin(const datasets::Experiment& experiment, std::uint64_t seed, int number);

// The same at a truth of the caller's.
Twin make_twin_at(const calibrate::ParameterSet& truth,
                  const datasets::Experiment& experiment,
                  std::uint64_t seed,
                  int number);

// A truth in the middle of what is likely: frictions 0.15 (particles) and 0.2 (wall), restitution
// 0.8.
calibrate::ParameterSet usual_truth();

// What is simulated to fit a problem; it must outlive the ensemble.
calibrate::Ensemble ensemble_of(const calibrate::Problem& problem,
                                calibrate::Journal& journal,
                                calibrate::Executor& executor);

// Simulations at a point with the seeds that confirm the winner of a calibration.
calibrate::Evaluation judge(const calibrate::EvaluationPoint& point,
                            const calibrate::CalibrationOptions& options,
                            calibrate::Ensemble& ensemble);

}  // namespace graintruth::bench
