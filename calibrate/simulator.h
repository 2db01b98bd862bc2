// All that the calibration knows of a simulator: one function. A test passes a lambda with known
// truth; any other engine fits behind ten lines.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

#include "calibrate/bulk_measure.h"
#include "calibrate/parameters.h"
#include "datasets/trajectories.h"

namespace graintruth::calibrate {

// How a simulation ended. Only a completed one is compared with the experiment; the others are
// counted, and scored as a model in which nothing moves.
enum class RunStatus { completed, unstable, timed_out };
std::string_view name_of(RunStatus status);

struct SimulationRequest {
  ParameterSet parameters;
  double time_step_fraction = 0.0;  // of the Rayleigh step, thesis eq 1.28 with pi
  std::uint64_t seed = 0;           // draws the starting poses
};

struct SimulatedRun {
  RunStatus status = RunStatus::completed;
  std::string message;  // one sentence where the run did not complete, or not at the step asked for
  datasets::Trajectories trajectories;  // at the times of the measurement; unseen after a bad end
  BinMeasurement bin;      // where particles run out of a bin, in place of trajectories
  double time_step = 0.0;  // s
  double seconds = 0.0;    // processor time spent
};

// Deterministic in its argument. Throws Interrupted, and nothing else, when the user wants to stop.
using Simulator = std::function<SimulatedRun(const SimulationRequest&)>;

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted; run the same command again to resume") {}
};

}  // namespace graintruth::calibrate
