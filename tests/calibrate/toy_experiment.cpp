#include "tests/calibrate/toy_experiment.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "calibrate/ensemble.h"

namespace graintruth::calibrate::toy {

datasets::Trajectories run(const ParameterSet& parameters, double noise, std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, noise);
  datasets::Trajectories tracks = datasets::make_trajectories(frames, particles, false);
  tracks.time = measurement_times(0.2, frames);
  for (std::size_t particle = 0; particle < particles; ++particle) {
    // Every particle drifts by its own offset for the whole run, as real ones do.
    const double x_offset = normal(generator);
    const double z_offset = normal(generator);
    const double angle_offset = normal(generator);
    const auto p = static_cast<double>(particle);
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const double t = tracks.time[frame];
      tracks.poses[tracks.index(frame, particle)] = {
          0.05 * p + 0.04 * t * parameters.friction_particle_particle + x_offset +
              0.3 * normal(generator),
          0.1 - 0.04 * t * (1.0 - parameters.friction_particle_wall * (1.0 + 0.1 * p)) + z_offset +
              0.3 * normal(generator),
          0.3 * p + 0.1 * t * parameters.friction_particle_particle + angle_offset +
              0.3 * normal(generator)};
    }
  }
  return tracks;
}

Simulator simulator(double noise) {
  return [noise](const SimulationRequest& request) {
    // The time step adds an error that falls with its square.
    ParameterSet shifted = request.parameters;
    shifted.friction_particle_particle +=
        0.2 * request.time_step_fraction * request.time_step_fraction;
    return SimulatedRun{.trajectories = run(shifted, noise, request.seed),
                        .time_step = 1e-5 * request.time_step_fraction,
                        .seconds = 0.0};
  };
}

Problem problem(const Truth& truth, int replicates, std::uint64_t seed) {
  datasets::Experiment experiment;
  experiment.name = "toy";
  experiment.particle = {.count = particles, .spheres = {{0.0, 0.01}}, .mass = 0.01};
  experiment.material = {.elastic_modulus = 1e9,
                         .poisson_ratio = 0.3,
                         .friction_particle_particle = {0.4, 0.0},
                         .friction_particle_wall = {0.4, 0.0},
                         .restitution = {0.8, 0.0}};
  experiment.measurement = {.frame_interval = 0.2, .frames = frames};
  experiment.tuned = {{"friction_particle_particle", 0.0, 0.6},
                      {"friction_particle_wall", 0.0, 0.7},
                      {"restitution", 0.3, 0.95}};
  std::vector<datasets::Trajectories> tracks;
  for (const std::uint64_t replicate_seed : make_seeds(seed, "toy replicates", replicates)) {
    experiment.replicates.push_back({.name = std::to_string(tracks.size() + 1)});
    tracks.push_back(run(truth.parameters, truth.noise, replicate_seed));
  }
  return make_problem(experiment, tracks);
}

}  // namespace graintruth::calibrate::toy
