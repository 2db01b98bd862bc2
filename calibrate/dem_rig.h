// What every simulation of an experiment shares: materials, particles, walls, clocks. Between the
// adapters to the embedded simulator (dem_simulator, bin_simulator) and it; nobody else needs it.
#pragma once

#include "calibrate/simulator.h"
#include "datasets/experiment.h"
#include "sim/simulation.h"

namespace graintruth::calibrate {

inline constexpr int particle_material = 0;
inline constexpr int wall_material = 1;

// Settling only has to bring the particles to rest, so its collisions are as dead as the model
// allows without stiffening the contact.
inline constexpr double settling_restitution = 0.2;

// Elasticity, surfaces and the particle of the experiment; no walls, no bodies. The particle is
// made of its element spheres; a plate without any of seven inscribed in its outline (thesis
// Appendix E). A plate has the inertia of a flat ellipse, whatever its spheres have.
sim::Scene empty_scene(const datasets::Experiment& experiment,
                       double elastic_modulus,
                       const ParameterSet& parameters,
                       double restitution);

void use_parameters(const ParameterSet& parameters, sim::Simulation& simulation);

// Processor time of this thread, s.
double thread_seconds();

RunStatus status_of(sim::RunStatus status);

}  // namespace graintruth::calibrate
