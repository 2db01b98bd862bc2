#include "calibrate/dem_simulator.h"

#include <algorithm>
#include <cmath>

#include "calibrate/dem_rig.h"

namespace graintruth::calibrate {

namespace {

// The scene of the experiment, without particles.
sim::Scene empty_rig(const datasets::Experiment& experiment,
                     const ParameterSet& parameters,
                     double restitution) {
  sim::Scene scene =
      empty_scene(experiment, experiment.material.elastic_modulus, parameters, restitution);
  for (const datasets::Wall& wall : experiment.rig.walls) {
    scene.add_wall(
        sim::segment_wall({wall.from_x, wall.from_z}, {wall.to_x, wall.to_z}, {}, wall_material));
  }
  if (const auto& piston = experiment.rig.piston) {
    const sim::WallMotion motion{.velocity = sim::Vec3(0.0, 0.0, piston->velocity_z),
                                 .start_time = 0.0};
    scene.add_wall(sim::segment_wall({piston->left_x, piston->face_z},
                                     {piston->right_x, piston->face_z},
                                     motion,
                                     wall_material));
  }
  return scene;
}

// The fastest collision that must be resolved: a fall by a tenth of the largest ball's diameter,
// which particles that follow a slow piston rarely exceed; the time-step gate checks what that
// leaves out.
double impact_speed(const datasets::Experiment& experiment) {
  double radius = 0.0;
  for (const datasets::AxialSphere& sphere : experiment.particle.spheres)
    radius = std::max(radius, sphere.radius);
  return std::sqrt(2.0 * experiment.rig.gravity * 0.1 * 2.0 * radius);
}

sim::SimulationOptions simulation_options(const datasets::Experiment& experiment, double fraction) {
  sim::SimulationOptions options;
  options.time_step.fraction = fraction;
  options.time_step.impact_speed = impact_speed(experiment);
  return options;
}

SimulatedRun simulate_particles(const datasets::Experiment& experiment,
                                const StartPoses& starts,
                                const DemSimulatorOptions& options,
                                const SimulationRequest& request) {
  const std::vector<double> times =
      measurement_times(experiment.measurement.frame_interval, experiment.measurement.frames);
  SimulatedRun run;
  run.trajectories = datasets::make_trajectories(times.size(), experiment.particle.count, false);
  run.trajectories.time = times;
  RunGuard guard(options, run);
  sim::Sampling sampling = guard.sampling();

  // 1. Particles where the films show them, moved apart where measured poses overlap
  const ParameterSet& parameters = request.parameters;
  sim::Scene scene =
      empty_rig(experiment, parameters, std::min(settling_restitution, parameters.restitution));
  if (!place_bodies(starts.mean, starts.standard_deviation, request.seed, scene, run)) return run;

  // 2. Rest on the still piston, with the friction of this run. Simulated time is film time plus
  // the settling time.
  for (sim::Wall& wall : scene.walls) wall.motion.start_time = options.settling_time;
  sim::Simulation simulation(scene, simulation_options(experiment, request.time_step_fraction));
  if (!guard.ended_well(simulation.run_until(options.settling_time, sampling))) return run;
  use_parameters(parameters, simulation);

  // 3. The piston sinks; what is seen at each frame is kept
  std::size_t frame = 0;
  sampling.interval = experiment.measurement.frame_interval;
  sampling.observer = [&](const sim::State& state) {
    if (frame >= times.size()) return;
    for (std::size_t particle = 0; particle < state.position.size(); ++particle) {
      run.trajectories.poses[run.trajectories.index(frame, particle)] = {
          state.position[particle].x(),
          state.position[particle].z(),
          state.picture_angle[particle]};
    }
    ++frame;
  };
  guard.ended_well(simulation.run_until(options.settling_time + times.back(), sampling));
  return run;
}

}  // namespace

Simulator make_dem_simulator(const datasets::Experiment& experiment,
                             const StartPoses& starts,
                             const DemSimulatorOptions& options) {
  return [experiment, starts, options](const SimulationRequest& request) {
    SimulatedRun run = simulate_particles(experiment, starts, options, request);
    run.trajectories = compared_part(std::move(run.trajectories), experiment.measurement.compared);
    return run;
  };
}

double largest_time_step_fraction(const datasets::Experiment& experiment) {
  sim::Scene scene = empty_rig(experiment, {}, 1.0);
  scene.add_planar_body(0, {0.0, 0.0}, 0.0);
  const sim::TimeStepOptions options{.fraction = 1.0, .impact_speed = impact_speed(experiment)};
  return sim::choose_time_step(scene, options) / sim::critical_time_step(scene);
}

}  // namespace graintruth::calibrate
