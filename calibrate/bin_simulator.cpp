#include "calibrate/bin_simulator.h"

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <numbers>

#include "calibrate/dem_rig.h"

namespace graintruth::calibrate {

namespace {

constexpr double settling_time = 0.1;     // s of rest on the closed orifice
constexpr double falling_time = 0.5;      // s that a prepared bed needs to rest after its last fall
constexpr double allowed_overlap = 0.01;  // of the particle diameter, in the hardest impact

// Rows from the floor up that touch neither each other nor the walls, at random angles and as
// randomly placed as that allows.
std::vector<datasets::Pose> loose_rows(const BinStart& start, std::uint64_t seed) {
  // Films share the seeds of an evaluation, but not their beds: they are different runs.
  boost::random::mt19937_64 generator(seed + static_cast<std::uint64_t>(start.prepared_bed));
  boost::random::uniform_real_distribution<double> share(0.0, 1.0);
  const double length = 2.0 * start.experiment.particle.plate->semi_major;
  const double width = start.experiment.rig.bin->width;
  const int columns = std::max(1, static_cast<int>(width / (1.02 * length)));
  const double pitch = width / columns;
  std::vector<datasets::Pose> bed;
  for (int i = 0; i < start.experiment.particle.count; ++i) {
    const double slack = (share(generator) - 0.5) * (pitch - length);
    bed.push_back({(i % columns + 0.5) * pitch - 0.5 * width + slack,
                   (i / columns + 0.5) * 1.02 * length,
                   std::numbers::pi * share(generator)});
  }
  return bed;
}

// The bin, closed: the stopper is the last wall. Its side walls reach up to `height` at least.
sim::Scene closed_bin(const BinStart& start,
                      const ParameterSet& parameters,
                      double restitution,
                      double height) {
  sim::Scene scene =
      empty_scene(start.experiment, simulated_modulus(start), parameters, restitution);
  for (const datasets::Wall& wall : start.experiment.rig.walls) {
    sim::Vec2 to(wall.to_x, wall.to_z);
    // A camera sees no particle above the side walls' ends, but a measured bed may touch them.
    if (wall.from_x == wall.to_x) to.y() = std::max(2.0 * to.y(), height);
    scene.add_wall(sim::segment_wall({wall.from_x, wall.from_z}, to, {}, wall_material));
  }
  const double half = 0.5 * start.rig.orifice;
  scene.add_wall(sim::segment_wall({-half, 0.0}, {half, 0.0}, {}, wall_material));
  return scene;
}

// The bodies that are still in the simulation, each with the particle that it is.
class Filmed {
 public:
  Filmed(const BinStart& start, std::vector<double> times)
      : lowest_(-start.rig.particle_diameter),
        tracks_(datasets::make_trajectories(times.size(), start.experiment.particle.count, false)) {
    tracks_.time = std::move(times);
    for (std::size_t i = 0; i < static_cast<std::size_t>(tracks_.particles); ++i)
      particle_.push_back(i);
  }

  // One frame; then takes out what has fallen far enough. False when nothing is left to see.
  bool record(std::size_t frame, sim::Simulation& simulation) {
    const sim::State& state = simulation.state();
    std::vector<int> fallen;
    std::vector<std::size_t> stay;
    for (std::size_t i = 0; i < particle_.size(); ++i) {
      const sim::Vec3& position = state.position[i];
      tracks_.poses[tracks_.index(frame, particle_[i])] = {
          position.x(), position.z(), state.picture_angle[i]};
      if (position.z() < lowest_) {
        fallen.push_back(static_cast<int>(i));
      } else {
        stay.push_back(particle_[i]);
      }
    }
    if (stay.empty()) return false;
    if (!fallen.empty()) simulation.remove_bodies(fallen);
    particle_ = std::move(stay);
    return true;
  }
  const datasets::Trajectories& tracks() const { return tracks_; }

 private:
  double lowest_;
  std::vector<std::size_t> particle_;
  datasets::Trajectories tracks_;
};

SimulatedRun simulate(const BinStart& start,
                      const DemSimulatorOptions& options,
                      const SimulationRequest& request) {
  SimulatedRun run;
  RunGuard guard(options, run);
  const sim::Sampling sampling = guard.sampling();

  // 1. The filmed bed, without overlap; or one that has yet to fall
  const ParameterSet& parameters = request.parameters;
  const bool prepared = start.bed.empty();
  const std::vector<datasets::Pose> bed = prepared ? loose_rows(start, request.seed) : start.bed;
  const double top = bed.back().z + start.rig.particle_diameter;  // of what falls
  ParameterSet settling = parameters;
  settling.restitution = std::min(settling_restitution, parameters.restitution);
  if (prepared) settling.friction_particle_particle = settling.friction_particle_wall = 0.0;
  sim::Scene scene = closed_bin(start, settling, settling.restitution, prepared ? top : 0.0);
  if (!place_bodies(bed, start.standard_deviation, request.seed, scene, run)) return run;

  // 2. Rest on the closed orifice
  sim::SimulationOptions choices;
  choices.time_step = {.fraction = request.time_step_fraction, .impact_speed = start.impact_speed};
  sim::Simulation simulation(scene, choices);
  double opening = settling_time;
  if (prepared) {
    opening += std::sqrt(2.0 * top / start.rig.gravity) + falling_time;
    if (!guard.ended_well(simulation.run_until(opening - settling_time, sampling))) return run;
    settling.friction_particle_particle = parameters.friction_particle_particle;
    settling.friction_particle_wall = parameters.friction_particle_wall;
    use_parameters(settling, simulation);
  }
  if (!guard.ended_well(simulation.run_until(opening, sampling))) return run;
  use_parameters(parameters, simulation);
  simulation.open_wall(static_cast<int>(scene.walls.size()) - 1, opening);

  // 3. Open, frame by frame
  const auto frames =
      static_cast<std::size_t>(std::floor(start.duration / start.frame_interval + 0.5)) + 1;
  std::vector<double> times;
  for (std::size_t frame = 0; frame < frames; ++frame)
    times.push_back(static_cast<double>(frame) * start.frame_interval);
  Filmed filmed(start, times);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    if (frame > 0 && !guard.ended_well(simulation.run_until(opening + times[frame], sampling)))
      return run;
    if (!filmed.record(frame, simulation)) break;
  }
  run.bin = measure_bin(filmed.tracks(), start.rig, start.profile_height);
  if (options.keep_tracks) run.trajectories = filmed.tracks();
  return run;
}

}  // namespace

Simulator make_bin_simulator(const BinStart& start, const DemSimulatorOptions& options) {
  return [start, options](const SimulationRequest& request) {
    return simulate(start, options, request);
  };
}

//   overlap = (5 m* v^2 / (4 k))^(2/5), k = 4/3 E* sqrt(R*)   (Hertz; sim/time_step.h)
// solved for E* of two equal particles, m* = m/2, R* = R/2, E* = E / (2 (1 - nu^2)).
double simulated_modulus(const BinStart& start) {
  const datasets::Material& material = start.experiment.material;
  const double speed = start.impact_speed;
  const double overlap = allowed_overlap * start.rig.particle_diameter;
  const double stiffness =
      1.25 * 0.5 * start.rig.particle_mass * speed * speed / std::pow(overlap, 2.5);
  const double reduced_modulus = 0.75 * stiffness / std::sqrt(0.25 * start.rig.particle_diameter);
  const double poisson = material.poisson_ratio;
  return std::min(material.elastic_modulus, 2.0 * (1.0 - poisson * poisson) * reduced_modulus);
}

double largest_time_step_fraction(const BinStart& start) {
  sim::Scene scene = closed_bin(start, {}, 1.0, 0.0);
  scene.add_planar_body(0, {0.0, 0.0}, 0.0);
  const sim::TimeStepOptions options{.fraction = 1.0, .impact_speed = start.impact_speed};
  return sim::choose_time_step(scene, options) / sim::critical_time_step(scene);
}

double largest_time_step_fraction(const BinProblem& problem) {
  double largest = 1.0;
  for (const BinStart& start : problem.starts)
    largest = std::min(largest, largest_time_step_fraction(start));
  return largest;
}

}  // namespace graintruth::calibrate
