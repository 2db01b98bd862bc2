#include "bench/calibrate/twins.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>

namespace graintruth::bench {

namespace {

constexpr datasets::Pose placing = {3.0e-4, 3.0e-4, 1.05e-2};  // m, m, rad; of one replicate
constexpr datasets::Pose tracking = {1.0e-4, 1.0e-4, 3.5e-3};  // of one pose

using Generator = boost::random::mt19937_64;

// The experiment as it is simulated from its nominal starting places.
calibrate::Problem nominal_problem(datasets::Experiment experiment) {
  // A camera sees all particles, whatever is compared
  experiment.measurement.observables = {{.name = "tracks"}};
  calibrate::FilmedStart start{.standard_deviation = placing};
  for (const datasets::StartPlace& place : experiment.starts)
    start.poses.push_back({place.x, place.z, place.angle});
  datasets::Trajectories still =
      datasets::make_trajectories(1, static_cast<int>(start.poses.size()), false);
  still.poses = start.poses;
  const std::vector<datasets::Recording> recordings(experiment.replicates.size(), {still});
  calibrate::Problem problem = calibrate::plan_problem(experiment, recordings);
  problem.scenes.front().spec.start = std::move(start);
  return problem;
}

// What a camera makes of the motion: every pose with an error of its own, and the size of it.
datasets::Trajectories filmed(datasets::Trajectories tracks, std::uint64_t seed) {
  Generator generator(seed);
  boost::random::normal_distribution<double> normal;
  tracks.sigmas.assign(tracks.poses.size(), tracking);
  tracks.scores.assign(tracks.poses.size(), 1.0);
  for (datasets::Pose& pose : tracks.poses) {
    pose.x += tracking.x * normal(generator);
    pose.z += tracking.z * normal(generator);
    pose.angle += tracking.angle * normal(generator);
  }
  return tracks;
}

}  // namespace

datasets::Experiment softened_micro_rig() {
  datasets::Experiment experiment = datasets::load_experiment(
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro" / "experiment.toml");
  experiment.material.elastic_modulus = softened_modulus;
  return experiment;
}

Twin make_twin_at(const calibrate::ParameterSet& truth,
                  const datasets::Experiment& experiment,
                  std::uint64_t seed,
                  int number) {
  const calibrate::Problem nominal = nominal_problem(experiment);
  const double fraction = nominal.largest_time_step_fraction() / 4.0;
  const std::string purpose = "twin " + std::to_string(number);
  const auto replicates = static_cast<int>(experiment.replicates.size());
  Twin twin{truth};
  for (const std::uint64_t run : calibrate::make_seeds(seed, purpose, replicates)) {
    const calibrate::EngineRun seen =
        nominal.engine->run(nominal.spec_of(0, truth, fraction, run), {});
    twin.recordings.push_back({filmed(seen.recording.tracks.value(), run)});
  }
  twin.problem = calibrate::make_problem(experiment, twin.recordings);
  return twin;
}

Twin make_twin(const datasets::Experiment& experiment, std::uint64_t seed, int number) {
  Generator generator(calibrate::make_seeds(seed, "truths", number + 1).back());
  boost::random::uniform_01<double> uniform;
  calibrate::ParameterSet truth;
  for (const datasets::TunedParameter& tuned : experiment.tuned)
    truth.set(tuned.name, tuned.lower + (tuned.upper - tuned.lower) * uniform(generator));
  return make_twin_at(truth, experiment, seed, number);
}

calibrate::ParameterSet usual_truth() {
  return {
      {"friction_particle_particle", 0.15}, {"friction_particle_wall", 0.2}, {"restitution", 0.8}};
}

calibrate::Ensemble ensemble_of(const calibrate::Problem& problem,
                                calibrate::Journal& journal,
                                calibrate::Executor& executor) {
  return {calibrate::scenes_of(problem, problem.calibrated_scenes, {}),
          journal,
          problem.calibrated,
          executor};
}

calibrate::Evaluation judge(const calibrate::EvaluationPoint& point,
                            const calibrate::CalibrationOptions& options,
                            calibrate::Ensemble& ensemble) {
  const auto seeds =
      calibrate::make_seeds(options.seed, "confirmation", options.confirmation_seeds);
  return ensemble.evaluate("judged", {&point, 1}, seeds).front();
}

}  // namespace graintruth::bench
