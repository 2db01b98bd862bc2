// Two glued balls fall on a floor, bounce, and come to rest: the simulator without the program.
#include <cstdio>

#include "sim/simulation.h"

int main() {
  using namespace graintruth::sim;
  Scene scene;
  const int grain = scene.add_material({.youngs_modulus = 1e8, .poisson_ratio = 0.3});
  const int steel = scene.add_material(rigid_material());
  scene.surfaces.set(grain, steel, {.friction = 0.3, .restitution = 0.5});
  const int pair = scene.add_type(make_clump(chain_of_spheres(2, 0.01, 0.015), {.density = 1e3}));
  scene.add_body(pair, {0.0, 0.0, 0.05});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, steel));
  Simulation simulation(scene);
  const RunSummary run = simulation.run_until(0.5);
  std::printf("after %g s at z = %.4f m\n", run.time, simulation.state().position[0].z());
}
