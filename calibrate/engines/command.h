// A program of the user's own as an engine.
#pragma once

#include "calibrate/engines/engine.h"

namespace graintruth::calibrate {

// Starts the spec's command with two more words, a folder of its own around it: spec.json, which it
// reads, and recording.json, which it writes:
//   {"time_step_s": 1e-5, "recording": {"curves": {"way_m": {"time_s": [...], "value": [...]}}}}
// with tracks and discharge as archives write them. `version`, where it writes one, is told in
// reports. A command that cannot be started, ends badly, takes too long or writes no recording
// gives a status with a sentence. An end with status 75 says that this simulation is unstable.
const Engine& command_engine();

}  // namespace graintruth::calibrate
