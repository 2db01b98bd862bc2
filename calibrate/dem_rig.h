// What every simulation of an experiment shares: materials, particles, walls, clocks. Between the
// adapters to the embedded simulator (dem_simulator, bin_simulator) and it; nobody else needs it.
#pragma once

#include <cstdint>
#include <span>

#include "calibrate/dem_simulator.h"
#include "sim/simulation.h"

namespace graintruth::calibrate {

inline constexpr int particle_material = 0;
inline constexpr int wall_material = 1;

// Settling only has to bring the particles to rest, so its collisions are as dead as the model
// allows without stiffening the contact.
inline constexpr double settling_restitution = 0.2;

// Elasticity, surfaces and the particle of the experiment; no walls, no bodies. The particle is
// that of particle_model.h.
sim::Scene empty_scene(const datasets::Experiment& experiment,
                       double elastic_modulus,
                       const ParameterSet& parameters,
                       double restitution);

void use_parameters(const ParameterSet& parameters, sim::Simulation& simulation);

// Bodies of type 0 at these poses plus a draw of their spread, moved apart where they overlap.
// False, with the reason in the run, where they cannot be.
bool place_bodies(std::span<const datasets::Pose> poses,
                  const datasets::Pose& standard_deviation,
                  std::uint64_t seed,
                  sim::Scene& scene,
                  SimulatedRun& run);

// Ends a run in time, and writes down how it ended.
class RunGuard {
 public:
  // Both must outlive it.
  RunGuard(const DemSimulatorOptions& options, SimulatedRun& run);

  // Asks between steps whether the user or the clock wants an end.
  sim::Sampling sampling() const;
  // Whether the run may go on. Throws Interrupted when the user wants to stop.
  bool ended_well(const sim::RunSummary& summary);

 private:
  const DemSimulatorOptions& options_;
  SimulatedRun& run_;
  double started_;  // s, of this thread's processor time
};

}  // namespace graintruth::calibrate
