#include "calibrate/executors/canary.h"

#include "calibrate/engines/engine.h"

namespace graintruth::calibrate {

SimulationSpec canary_spec() {
  using datasets::SceneWall;
  SimulationSpec spec;
  spec.engine_version = engine_named("embedded").version();
  spec.time_step_fraction = 0.4;
  spec.seed = 7;
  datasets::SceneData& scene = spec.scene;
  // 1. A grain of two unequal spheres
  scene.materials = {
      {.name = "grain", .elastic_modulus = 5e6, .poisson_ratio = 0.3},
      {.name = "wall", .is_rigid = true},
  };
  for (const int second : {0, 1}) {
    scene.surfaces.push_back({.first = 0,
                              .second = second,
                              .friction = 0.3,
                              .restitution = 0.6,
                              .static_friction = 0.4,
                              .rolling_friction = 0.05});
  }
  scene.particles = {{.name = "clump",
                      .count = 12,
                      .spheres = {{{-4e-3, 0.0, 0.0}, 5e-3}, {{4e-3, 0.0, 0.0}, 6e-3}},
                      .density = 1200.0}};
  scene.particles.front().size = {
      .kind = datasets::SizeSpread::Kind::lognormal, .standard_deviation = 0.1, .classes = 3};
  // 2. A box with a tilted side and a floor that moves
  const auto plane = [&](const char* name, Eigen::Vector3d point, Eigen::Vector3d normal) {
    SceneWall wall{.name = name, .material = 1, .kind = SceneWall::Kind::plane};
    wall.points = {point};
    wall.normal = normal.normalized();
    scene.walls.push_back(wall);
  };
  plane("floor", {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
  scene.walls.back().motion.velocity.z() = 0.02;
  plane("left", {-0.05, 0.0, 0.0}, {1.0, 0.0, 0.3});
  plane("right", {0.05, 0.0, 0.0}, {-1.0, 0.0, 0.0});
  plane("front", {0.0, -0.03, 0.0}, {0.0, 1.0, 0.0});
  plane("back", {0.0, 0.03, 0.0}, {0.0, -1.0, 0.0});
  // 3. They fall
  scene.fill.low = {-0.04, -0.025, 0.01};
  scene.fill.high = {0.045, 0.025, 0.15};
  scene.fill.clearance = 1e-3;
  datasets::ScenePhase fall{.name = "fall", .duration = 0.2, .output_interval = 0.05};
  fall.time_step_fraction = spec.time_step_fraction;
  fall.fastest_impact = 2.0;
  scene.phases = {fall};
  spec.record.curves = {"highest_grain_m", "wall_force_floor_z_n"};
  return spec;
}

}  // namespace graintruth::calibrate
