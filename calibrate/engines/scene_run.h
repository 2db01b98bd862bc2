// Runs a scene file from its first particle to its last phase, and keeps what is seen on the way.
#pragma once

#include <string>
#include <vector>

#include "calibrate/engines/scene_runner.h"
#include "sim/engine/contact_summary.h"

namespace graintruth::calibrate {

// How the particles hang together at one moment.
struct BedState {
  int contacts = 0;            // touching spheres, walls included
  double coordination = 0.0;   // partners a particle; each other particle and each wall counts once
  double mean_force = 0.0;     // N; normal, over contacts
  double largest_force = 0.0;  // N; now
  double peak_force = 0.0;     // N; of all steps since the frame before
  double sliding_share = 0.0;  // of contacts
  int discharged = 0;          // particles below the exit height
  double discharged_mass = 0.0;  // kg
};

struct SceneFrame {
  sim::State state;  // time as simulated, the start of the filling being 0
  sim::Energy energy;
  BedState bed;
  std::vector<sim::Vec3> wall_force;  // N, one a SceneFile::walls
  std::vector<double> wall_peak;      // N; largest force of one contact since the frame before
  // N; normal force by the strips of SceneRun::strips, one list a SceneFile::walls; none before the
  // event
  std::vector<std::vector<double>> strip_force;
  std::vector<sim::Wall> walls;  // where they are; empty when where they were in the frame before
};

struct SceneRun {
  sim::RunStatus status = sim::RunStatus::completed;
  std::string message;
  double event_time = 0.0;  // s, as simulated: times in files count from here
  bool reached_event = false;
  sim::Strips strips;  // tenths of the height of the bed at the event
  std::vector<SceneFrame> frames;
  std::vector<PhaseRecord> phases;
  sim::Scene scene;                          // types, and all bodies, as they are in the end
  std::vector<int> owner;                    // of a wall of the frames, into SceneFile::walls
  std::vector<ParticleKind> kinds;           // one a SceneFile::particles
  std::vector<sim::ContactReport> contacts;  // in the end
  std::vector<std::string> warnings;

  // The walls as they stand in a frame.
  const std::vector<sim::Wall>& walls_at(std::size_t frame) const;
};

// Throws datasets::InputError where the scene cannot start. The same file and seed give the same
// bits.
SceneRun run_scene(const datasets::SceneFile& file, const SceneRunOptions& options);

}  // namespace graintruth::calibrate
