// Twins: experiments made by the simulator itself, so that their truth is known. For studies of the
// calibration; nothing here is used by the program.
#pragma once

#include <filesystem>

#include "calibrate/ensemble.h"
#include "calibrate/problem.h"

namespace graintruth::bench {

struct Twin {
  calibrate::ParameterSet truth;
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

// What is simulated to fit a twin: the experiment from the twin's own measured starts.
calibrate::Scene scene_of(const Twin& twin, const datasets::Experiment& experiment);

}  // namespace graintruth::bench
