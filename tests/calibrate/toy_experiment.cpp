#include "tests/calibrate/toy_experiment.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "calibrate/observables/moments.h"
#include "datasets/rigs/followed_grains.h"

namespace graintruth::calibrate::toy {

datasets::Trajectories run(const ParameterSet& parameters, double noise, std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, noise);
  datasets::Trajectories tracks = datasets::make_trajectories(frames, particles, false);
  tracks.time = measurement_times(0.2, frames);
  const double between = parameters.of("friction_particle_particle");
  const double wall = parameters.of("friction_particle_wall");
  for (std::size_t particle = 0; particle < particles; ++particle) {
    // Every particle drifts by its own offset for the whole run, as real ones do.
    const double x_offset = normal(generator);
    const double z_offset = normal(generator);
    const double angle_offset = normal(generator);
    const auto p = static_cast<double>(particle);
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const double t = tracks.time[frame];
      tracks.poses[tracks.index(frame, particle)] = {
          0.05 * p + 0.04 * t * between + x_offset + 0.3 * normal(generator),
          0.1 - 0.04 * t * (1.0 - wall * (1.0 + 0.1 * p)) + z_offset + 0.3 * normal(generator),
          0.3 * p + 0.1 * t * between + angle_offset + 0.3 * normal(generator)};
    }
  }
  return tracks;
}

EngineRun as_run(datasets::Trajectories tracks) {
  EngineRun run{.time_step = 1e-5};
  run.recording.tracks = std::move(tracks);
  return run;
}

ClosedEngine engine(double noise) {
  return ClosedEngine([noise](const SimulationSpec& spec) {
    ParameterSet shifted = spec.parameters;
    shifted.set("friction_particle_particle",
                shifted.of("friction_particle_particle") +
                    0.2 * spec.time_step_fraction * spec.time_step_fraction);
    EngineRun made = as_run(run(shifted, noise, spec.seed));
    made.time_step = 1e-5 * spec.time_step_fraction;
    return made;
  });
}

std::vector<datasets::Recording> recordings(const Truth& truth,
                                            int replicates,
                                            std::uint64_t seed) {
  std::vector<datasets::Recording> made;
  for (const std::uint64_t replicate_seed : make_seeds(seed, "toy replicates", replicates))
    made.push_back({.tracks = run(truth.parameters, truth.noise, replicate_seed)});
  return made;
}

datasets::Experiment experiment(int replicates) {
  datasets::Experiment made;
  made.name = "toy";
  made.particle = datasets::particle_of(
      {.spheres = {{Eigen::Vector3d::Zero(), 0.01}}, .mass = 0.01}, particles);
  made.material = {.elastic_modulus = 1e9,
                   .poisson_ratio = 0.3,
                   .bench = {{"friction_particle_particle", {0.4, 0.0}},
                             {"friction_particle_wall", {0.4, 0.0}},
                             {"restitution", {0.8, 0.0}}}};
  made.rig.walls = {{"floor", -1.0, 0.0, 1.0, 0.0}};
  datasets::follow_grains({.particle = &made.particle}, made.rig);
  made.measurement = {.frame_interval = 0.2, .frames = frames, .observables = {{.name = "tracks"}}};
  made.tuned = {{"friction_particle_particle", 0.0, 0.6},
                {"friction_particle_wall", 0.0, 0.7},
                {"restitution", 0.3, 0.95}};
  for (int i = 0; i < replicates; ++i)
    made.replicates.push_back({.name = std::to_string(i + 1), .rig = made.rig});
  return made;
}

Problem problem(const Truth& truth, int replicates, std::uint64_t seed) {
  return make_problem(experiment(replicates), recordings(truth, replicates, seed));
}

SimulatedRun compared(const Problem& problem, const datasets::Trajectories& tracks) {
  return {.channels = problem.observables->measure(
              {.tracks = tracks}, problem.situations.front(), &problem.measured.front())};
}

std::unique_ptr<Ensemble> ensemble(Problem& problem,
                                   const Engine& engine,
                                   Journal& journal,
                                   Executor& executor) {
  problem.engine = &engine;
  return std::make_unique<Ensemble>(
      scenes_of(problem, problem.calibrated_scenes, {}), journal, problem.calibrated, executor);
}

CalibrationResult calibrated(const Engine& engine,
                             Problem problem,
                             const CalibrationOptions& options) {
  problem.engine = &engine;
  Journal journal(":memory:");
  const auto executor = make_executor("threads", options.jobs);
  const std::array experiments = {CalibratedExperiment{problem.experiment.name, &problem}};
  return calibrate(problem.experiment, experiments, journal, *executor, {}, options);
}

}  // namespace graintruth::calibrate::toy
