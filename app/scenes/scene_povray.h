// A simulated scene as input for the ray tracer POV-Ray.
#pragma once

#include "calibrate/engines/scene_run.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

// povray/frame_*.pov, one a frame, each drawn by "povray +Iframe_00000.pov +W1280 +H800 +A -D" in
// that folder, and povray/scene.inc with camera, light and colours, which all of them include.
void write_povray(const datasets::RunFolder& folder,
                  const datasets::SceneFile& file,
                  const calibrate::SceneRun& run);

}  // namespace graintruth::app
