// What a simulated scene leaves in its run folder.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibrate/engines/scene_run.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/trajectories.h"

namespace graintruth::app {

// Of a planar scene, times counted from the event; a particle that has not rained in yet is unseen.
datasets::Trajectories planar_tracks(const calibrate::SceneRun& run);

// tracks/simulation.csv and tables/*.csv.
void write_scene_tables(const datasets::RunFolder& folder,
                        const datasets::SceneFile& file,
                        const calibrate::SceneRun& run);

// paraview/spheres.pvd and walls.pvd with a .vtp a frame.
void write_paraview(const datasets::RunFolder& folder, const calibrate::SceneRun& run);
// dump.lammpstrj
void write_ovito(const datasets::RunFolder& folder, const calibrate::SceneRun& run);

// result.json without the wall time.
nlohmann::ordered_json scene_result(const datasets::SceneFile& file,
                                    const calibrate::SceneRun& run);
// The resolved scene, for run.json.
nlohmann::ordered_json scene_configuration(const datasets::SceneFile& file);

}  // namespace graintruth::app
