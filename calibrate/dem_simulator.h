// The adapter to the embedded simulator for particles that stay in their rig. What runs out of a
// bin is simulated by bin_simulator.h; both build on dem_rig.h, and nothing else here knows of
// sim/.
#pragma once

#include <functional>

#include "calibrate/problem.h"
#include "calibrate/simulator.h"

namespace graintruth::calibrate {

struct DemSimulatorOptions {
  double settling_time = 0.3;  // s of rest on the still piston before the event
  double time_limit = 120.0;   // s of processor time, after which a run counts as timed out
  std::function<bool()> stop;  // asked now and then; true: throw Interrupted
  bool keep_tracks = false;    // of what runs out of a bin; other runs always have them
};

// The experiment as a simulation: nominal particles in one layer, started from the mean measured
// first poses plus a draw of their measured spread, moved apart where they overlap, settled under
// gravity with the friction of the request, then let go with the piston at time 0.
Simulator make_dem_simulator(const datasets::Experiment& experiment,
                             const StartPoses& starts,
                             const DemSimulatorOptions& options);

// The largest fraction of the Rayleigh step that gives every contact of this experiment at least 20
// steps.
double largest_time_step_fraction(const datasets::Experiment& experiment);

}  // namespace graintruth::calibrate
