// An experiment whose every result is known: particles on straight, smooth tracks that depend on
// the parameters in closed form, with noise of known size. For tests of statistics and search, not
// of physics.
#pragma once

#include "calibrate/calibration.h"
#include "tests/support/closed_engine.h"
#include "tests/support/parameters.h"

namespace graintruth::calibrate::toy {

using tests::ClosedEngine;
using tests::parameters;

struct Truth {
  ParameterSet parameters = tests::parameters(0.2, 0.3, 0.7);
  double noise = 0.002;  // m (and rad) of one run or replicate
};

inline constexpr int particles = 6;
inline constexpr int frames = 12;

// One run at these parameters; restitution has no effect.
datasets::Trajectories run(const ParameterSet& parameters, double noise, std::uint64_t seed);
EngineRun as_run(datasets::Trajectories tracks);
// The time step adds an error that falls with its square.
ClosedEngine engine(double noise);

// The toy's replicates at the truth, as a problem with bounds 0-0.6, 0-0.7 and 0.3-0.95. Its engine
// simulates nothing: tests put in their own.
std::vector<datasets::Recording> recordings(const Truth& truth, int replicates, std::uint64_t seed);
datasets::Experiment experiment(int replicates);
Problem problem(const Truth& truth, int replicates, std::uint64_t seed);

// Tracks as they are compared.
SimulatedRun compared(const Problem& problem, const datasets::Trajectories& tracks);

// Everything that is simulated for the problem, by this engine.
std::unique_ptr<Ensemble> ensemble(Problem& problem,
                                   const Engine& engine,
                                   Journal& journal,
                                   Executor& executor);

// A whole calibration on two threads, with a journal of its own.
CalibrationResult calibrated(const Engine& engine,
                             Problem problem,
                             const CalibrationOptions& options);

}  // namespace graintruth::calibrate::toy
