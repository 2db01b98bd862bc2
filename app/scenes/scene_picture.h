// Pictures of a simulated scene: a film of all frames and a still of the last.
#pragma once

#include <filesystem>
#include <functional>

#include "calibrate/engines/scene_run.h"

namespace graintruth::app {

// simulation.mp4 (with more than one frame) and simulation.png in the folder. Planar scenes are
// seen from the side, with the outline of every clump and a mark along its long axis; others in a
// shaded parallel projection. Throws datasets::InputError when they cannot be written.
void render_scene(const std::filesystem::path& folder,
                  const datasets::SceneFile& file,
                  const calibrate::SceneRun& run,
                  const std::function<void(double)>& progress);

}  // namespace graintruth::app
