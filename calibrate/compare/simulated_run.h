// One simulation as it is compared: how it ended, and what was measured of it.
#pragma once

#include <string>
#include <vector>

#include "calibrate/engines/engine.h"
#include "calibrate/observables/channel.h"
#include "datasets/parameters/parameter_set.h"

namespace graintruth::calibrate {

using datasets::ParameterSet;

struct SimulatedRun {
  RunStatus status = RunStatus::completed;
  std::string message;  // one sentence where the run did not complete, or not at the step asked for
  std::vector<Channel> channels;  // of all observables of its experiment; empty after a bad end
  double time_step = 0.0;         // s
  double seconds = 0.0;           // processor time spent
};

}  // namespace graintruth::calibrate
