#include "app/thesis/lone_row.h"

#include <numbers>

#include "calibrate/ensemble.h"

namespace graintruth::app {

sim::TimeStepOptions exactly(double time_step) {
  // Slow impacts and few steps a contact, so that no other limit is nearer
  return {.fraction = 1.0, .impact_speed = 0.01, .steps_per_contact = 1.0, .largest = time_step};
}

sim::Simulation on_plane(const LoneRow& row, double time_step, sim::SimulationOptions options) {
  sim::Scene scene;
  scene.planar = true;
  scene.gravity = row.gravity;
  const int grain = scene.add_material(row.material);
  const int rigid = scene.add_material(sim::rigid_material());
  scene.surfaces.set(grain, rigid, {.friction = row.friction, .restitution = row.restitution});
  const int type = scene.add_type(sim::make_clump(
      sim::chain_of_spheres(row.spheres, row.radius, row.spacing), {.mass = row.mass}, grain));
  const double reach = row.radius + (row.is_upright ? 0.5 * (row.spheres - 1) * row.spacing : 0.0);
  const double angle = row.is_upright ? 0.5 * std::numbers::pi : 0.0;
  scene.add_planar_body(type,
                        sim::Vec2(0.0, reach + row.gap),
                        angle,
                        sim::into_plane(row.velocity),
                        row.picture_spin);
  sim::Wall plane = sim::plane_wall(sim::Vec3::Zero(), sim::Vec3::UnitZ(), {}, rigid);
  plane.drag.velocity = sim::Vec3(row.belt_speed, 0.0, 0.0);
  scene.add_wall(plane);
  options.time_step = exactly(time_step);
  return sim::Simulation(scene, options);
}

std::vector<double> shares_of_seed(std::uint64_t seed, std::string_view purpose, int count) {
  std::vector<double> shares;
  for (const std::uint64_t drawn : calibrate::make_seeds(seed, purpose, count))
    shares.push_back(static_cast<double>(drawn) * 0x1.0p-53);  // seeds have 53 bits
  return shares;
}

}  // namespace graintruth::app
