// The beds on which Graintruth's simulator is compared with other engines: buttons in a bin, rods
// in a wide bin, clumps and single spheres in a box. One definition for all engines.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene.h"
#include "sim/simulation.h"

namespace graintruth::bench {

// A bed of equal clumps of one material between walls of the same elasticity.
struct PeerCase {
  std::string name;
  bool planar = false;
  int clump_count = 0;
  std::vector<sim::ElementSphere> spheres;  // body frame, long axis x
  double mass = 0.0;                        // kg
  sim::Vec3 inertia = sim::Vec3::Zero();    // kg m2, principal
  sim::Material material = {.youngs_modulus = 3.5e9, .poisson_ratio = 0.3};
  double restitution = 0.5;
  double friction = 0.2;       // clump on clump
  double wall_friction = 0.5;  // clump on wall
  double width = 0.0;          // m; x from 0 to here
  double depth = 0.0;          // m; y from 0 to here, boxes only
  double height = 0.0;         // m; room for the bed before it settles
  double orifice = 0.0;        // m; width of the hole in the middle of the floor, 0: closed
  double time_step = 0.0;      // s
  // Steps of a short and of a long run; what a step costs is their difference.
  int short_run = 0, long_run = 0;
  double lammps_skin = 0.0, liggghts_skin = 0.0;  // m; the fastest of those tried
};

// All cases: a settled bed for each, and the open orifice where there is one.
std::vector<PeerCase> peer_cases();

// Where the bodies are: centres of mass and orientations.
struct Pose {
  sim::Vec3 position;
  sim::Quat orientation;
};

// The settled bed of the case with its orifice shut, without friction so that it is dense. Read
// from `folder` when it has been made before, else simulated and written there.
std::vector<Pose> settled_bed(const PeerCase& peer_case, const std::filesystem::path& folder);

// The scene at rest, orifice open when the case has one.
sim::Scene scene_of(const PeerCase& peer_case, const std::vector<Pose>& poses);

// Options under which every step is exactly the case's time step.
sim::SimulationOptions options_of(const PeerCase& peer_case);

// A sphere of any engine's result.
struct PlacedSphere {
  int body;
  sim::Vec3 centre;
  double radius;
};
std::vector<PlacedSphere> placed_spheres(const PeerCase& peer_case, const std::vector<Pose>& poses);

// Counted from positions alone, the same way for every engine.
struct ContactCount {
  int between_spheres = 0;
  int with_walls = 0;
  double bodies_per_body =
      0.0;  // touching bodies and walls per body; several contacts of a pair once
};
ContactCount count_contacts(const PeerCase& peer_case, const std::vector<PlacedSphere>& spheres);

}  // namespace graintruth::bench
