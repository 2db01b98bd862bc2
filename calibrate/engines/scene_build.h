// A scene file as a scene of the simulator: materials, kinds of particles and walls, still empty.
#pragma once

#include <string>
#include <vector>

#include "datasets/scene/scene_file.h"
#include "sim/shapes/surface_error.h"
#include "sim/simulation.h"

namespace graintruth::calibrate {

// A ball around all spheres of a type, in its body frame.
struct EnclosingBall {
  sim::Vec3 centre = sim::Vec3::Zero();  // m
  double radius = 0.0;                   // m
};

struct ParticleKind {
  std::vector<int> types;       // one a size class, into sim::Scene::types
  sim::SurfaceError roughness;  // of the nominal size; zero unless its spheres lie on a line
  double protrusion = 0.0;      // m; of a fitted profile
};

struct BuiltScene {
  sim::Scene scene;
  std::vector<ParticleKind> kinds;       // one a SceneFile::particles
  std::vector<EnclosingBall> enclosing;  // one a sim::Scene::types
  std::vector<int> owner;                // of sim::Scene::walls, into SceneFile::walls
  std::vector<std::string> warnings;     // sentences
  std::string origin;                    // for sentences
};

// Walls do not move yet: see start_walls. `origin` is named in sentences: the file that the scene
// comes from. Throws datasets::InputError for shapes that cannot be.
BuiltScene build_scene(const datasets::SceneData& data, const std::string& origin);

// The spheres of one nominal particle, in the frame of its shape.
std::vector<sim::ElementSphere> spheres_of(const datasets::SceneParticle& particle);

// The form of the contact law, into the options of the simulation.
void use_law(const datasets::SceneLaw& law, sim::SimulationOptions& options);

// The surfaces of the file with what a phase sets in their place.
void use_surfaces(const datasets::SceneData& file,
                  const datasets::ScenePhase& phase,
                  sim::SurfaceTable& surfaces);

// Lets the walls move, drag and open as the file says, `time` being the event.
void start_walls(const datasets::SceneData& file,
                 const BuiltScene& built,
                 double time,
                 sim::Simulation& simulation);

}  // namespace graintruth::calibrate
