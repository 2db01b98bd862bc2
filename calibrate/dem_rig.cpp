#include "calibrate/dem_rig.h"

#include <ctime>

#include "sim/profile.h"

namespace graintruth::calibrate {

namespace {

constexpr int plate_chords = 8;  // seven spheres

sim::Clump clump_of(const datasets::Particle& particle) {
  std::vector<sim::ElementSphere> spheres;
  for (const datasets::AxialSphere& sphere : particle.spheres)
    spheres.push_back({sim::Vec3(sphere.offset, 0.0, 0.0), sphere.radius});
  sim::MassChoice choice{.mass = particle.mass};
  if (const auto& plate = particle.plate) {
    const double a = plate->semi_major * plate->semi_major;
    const double b = plate->semi_minor * plate->semi_minor;
    const double t = plate->thickness * plate->thickness / 3.0;
    // I = m/4 (sum of squared half axes across), a flat ellipse's; the thickness adds m t^2/12
    choice.inertia = 0.25 * particle.mass * sim::Vec3(b + t, a + b, a + t);
    if (spheres.empty()) {
      spheres =
          sim::fit_profile(sim::ellipse_profile(plate->semi_major, plate->semi_minor), plate_chords)
              .spheres;
    }
  }
  return sim::make_clump(std::move(spheres), choice, particle_material);
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

}  // namespace graintruth::calibrate
