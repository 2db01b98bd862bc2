// The embedded multi-sphere simulator as an engine.
#pragma once

#include "calibrate/engines/engine.h"
#include "calibrate/engines/scene_build.h"

namespace graintruth::calibrate {

// Runs the spec's scene phase by phase. Grains of a filmed start, and those filled in rows, are
// moved apart where they overlap. Records at the frames of the phases from the event on:
//   tracks               pose of every grain; the angle only in one layer
//   outline              upper edge of the grains' silhouette, in the columns of the plan
//   discharge            mass below the scene's exit height
//   wall_force_<w>_x_n   force of the grains on the wall of that name, N; _y_n and _z_n likewise
//   highest_grain_m      of the centres
const Engine& embedded_engine();

// The scene of a spec as it starts: every body that is there then, in its place. Throws
// datasets::InputError, or std::invalid_argument, where it cannot start.
BuiltScene start_of(const SimulationSpec& spec);

}  // namespace graintruth::calibrate
