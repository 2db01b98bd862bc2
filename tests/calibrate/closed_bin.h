// A weighed bin whose every result is known: grains that leave at a constant rate, which falls with
// the friction between particles, while what stays behind grows with that of the wall. For tests of
// statistics and search, not of physics.
#pragma once

#include "calibrate/calibration.h"
#include "tests/support/closed_engine.h"
#include "tests/support/parameters.h"

namespace graintruth::calibrate::closed_bin {

using tests::parameters;

inline constexpr int particles = 200;
inline constexpr double narrow = 0.06;  // m; narrower orifices are held out
inline constexpr std::array orifices = {0.05, 0.075, 0.085, 0.1};  // m

// Three weighed replicates an orifice at the truth; `noise` is relative, of one run.
datasets::Experiment experiment();
std::vector<datasets::Recording> recordings(const ParameterSet& truth,
                                            double noise,
                                            std::uint64_t seed);
Problem problem(const ParameterSet& truth, double noise, std::uint64_t seed);

// Every replicate has a bed of its own, so that runs of different ones scatter on their own.
tests::ClosedEngine engine(double noise);

// The runs that the engine makes of what is calibrated on, `seeds` each.
Evaluation evaluated(const Problem& problem,
                     const Engine& engine,
                     const ParameterSet& parameters,
                     std::uint64_t first_seed,
                     int seeds);

CalibrationResult calibrated(const Engine& engine, Problem problem, std::uint64_t seed);

}  // namespace graintruth::calibrate::closed_bin
