#include "bench/calibrate/twins.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>

#include "calibrate/dem_simulator.h"

namespace graintruth::bench {

namespace {

constexpr datasets::Pose placing = {3.0e-4, 3.0e-4, 1.05e-2};  // m, m, rad; of one replicate
constexpr datasets::Pose tracking = {1.0e-4, 1.0e-4, 3.5e-3};  // of one pose
constexpr int replicates = 5;

using Generator = boost::random::mt19937_64;

calibrate::StartPoses nominal_starts(const datasets::Experiment& experiment) {
  calibrate::StartPoses starts{.standard_deviation = placing};
  for (const datasets::StartPlace& place : experiment.starts)
    starts.mean.push_back({place.x, place.z, place.angle});
  return starts;
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
  datasets::Experiment seen = experiment;  // a camera sees all particles, whatever is compared
  seen.measurement.compared = datasets::Compared::particles;
  const calibrate::Simulator simulator =
      calibrate::make_dem_simulator(seen, nominal_starts(seen), {});
  const double fraction = calibrate::largest_time_step_fraction(experiment) / 4.0;
  const std::string purpose = "twin " + std::to_string(number);
  std::vector<datasets::Trajectories> tracks;
  for (const std::uint64_t run : calibrate::make_seeds(seed, purpose, replicates))
    tracks.push_back(filmed(simulator({truth, fraction, run}).trajectories, run));
  return {truth, calibrate::make_problem(experiment, tracks)};
}

Twin make_twin(const datasets::Experiment& experiment, std::uint64_t seed, int number) {
  Generator generator(calibrate::make_seeds(seed, "truths", number + 1).back());
  boost::random::uniform_01<double> uniform;
  calibrate::ParameterSet truth;
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    calibrate::value_of(truth, tuned.name) =
        tuned.lower + (tuned.upper - tuned.lower) * uniform(generator);
  }
  return make_twin_at(truth, experiment, seed, number);
}

calibrate::Scene scene_of(const Twin& twin, const datasets::Experiment& experiment) {
  return {twin.problem.hash, calibrate::make_dem_simulator(experiment, twin.problem.starts, {})};
}

}  // namespace graintruth::bench
