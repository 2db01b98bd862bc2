#include "calibrate/dem_rig.h"

#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <ctime>

#include "calibrate/particle_model.h"
#include "sim/relaxation.h"

namespace graintruth::calibrate {

namespace {

sim::Clump clump_of(const datasets::Particle& particle) {
  std::vector<sim::ElementSphere> spheres;
  for (const datasets::AxialSphere& sphere : element_spheres(particle))
    spheres.push_back({sim::Vec3(sphere.offset, 0.0, 0.0), sphere.radius});
  sim::MassChoice choice{.mass = particle.mass};
  if (const auto inertia = stated_inertia(particle))
    choice.inertia = sim::Vec3((*inertia)[0], (*inertia)[1], (*inertia)[2]);
  return sim::make_clump(std::move(spheres), choice, particle_material);
}

// Processor time of this thread, s.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1.0e-9 * static_cast<double>(now.tv_nsec);
}

RunStatus status_of(sim::RunStatus status) {
  switch (status) {
    case sim::RunStatus::completed:
      return RunStatus::completed;
    case sim::RunStatus::unstable:
      return RunStatus::unstable;
    case sim::RunStatus::timed_out:
      return RunStatus::timed_out;
  }
  return RunStatus::unstable;
}

}  // namespace

sim::Scene empty_scene(const datasets::Experiment& experiment,
                       double elastic_modulus,
                       const ParameterSet& parameters,
                       double restitution) {
  sim::Scene scene;
  scene.planar = true;
  scene.gravity = sim::Vec3(0.0, 0.0, -experiment.rig.gravity);
  scene.add_material({elastic_modulus, experiment.material.poisson_ratio});
  scene.add_material(sim::rigid_material());
  scene.surfaces.set(
      particle_material, particle_material, {parameters.friction_particle_particle, restitution});
  scene.surfaces.set(
      particle_material, wall_material, {parameters.friction_particle_wall, restitution});
  scene.add_type(clump_of(experiment.particle));
  return scene;
}

void use_parameters(const ParameterSet& parameters, sim::Simulation& simulation) {
  simulation.set_surfaces(particle_material,
                          particle_material,
                          {parameters.friction_particle_particle, parameters.restitution});
  simulation.set_surfaces(particle_material,
                          wall_material,
                          {parameters.friction_particle_wall, parameters.restitution});
}

bool place_bodies(std::span<const datasets::Pose> poses,
                  const datasets::Pose& standard_deviation,
                  std::uint64_t seed,
                  sim::Scene& scene,
                  SimulatedRun& run) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal;
  for (const datasets::Pose& pose : poses) {
    const double x = pose.x + standard_deviation.x * normal(generator);
    const double z = pose.z + standard_deviation.z * normal(generator);
    const double angle = pose.angle + standard_deviation.angle * normal(generator);
    scene.add_planar_body(0, {x, z}, angle);
  }
  const sim::RelaxationSummary relaxed = sim::relax_overlaps(scene);
  if (relaxed.converged) return true;
  run.status = RunStatus::unstable;
  run.message = fmt::format("the starting poses cannot be freed of overlap ({:.2g} m is left)",
                            relaxed.overlap_after);
  return false;
}

RunGuard::RunGuard(const DemSimulatorOptions& options, SimulatedRun& run)
    : options_(options), run_(run), started_(thread_seconds()) {}

sim::Sampling RunGuard::sampling() const {
  sim::Sampling sampling;
  sampling.should_stop = [this] {
    return (options_.stop && options_.stop()) || thread_seconds() - started_ > options_.time_limit;
  };
  return sampling;
}

bool RunGuard::ended_well(const sim::RunSummary& summary) {
  if (options_.stop && options_.stop()) throw Interrupted();
  run_.status = status_of(summary.status);
  run_.message = summary.message;
  if (summary.time_step > 0.0) run_.time_step = summary.time_step;
  run_.seconds = thread_seconds() - started_;
  return run_.status == RunStatus::completed;
}

}  // namespace graintruth::calibrate
