// Parameters that a calibration moves, by what they do to a body of which a closed form is known.
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/engines/embedded.h"
#include "datasets/parameters/apply.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr double radius = 0.01, gravity = 9.81;  // m, m/s2

// A ball on a rigid floor that moves to the right and turns, for half a second.
SimulationSpec ball_on_a_floor(double velocity, double spin, double height = radius) {
  const tests::TemporaryFolder folder;
  const auto file = folder.write("scene.toml", R"(
title = "A ball on a floor"
dimensions = 2
[[material]]
name = "ball"
elastic_modulus_mpa = 50
poisson_ratio = 0.3
[[material]]
name = "floor"
rigid = true
[[surfaces]]
first = "ball"
second = "floor"
friction = 0.5
restitution = 0.9
[[surfaces]]
first = "ball"
second = "ball"
friction = 0.5
restitution = 0.9
[[particle]]
name = "ball"
material = "ball"
count = 0
density_g_per_cm3 = 1.2
radius_mm = 10
[[wall]]
name = "floor"
material = "floor"
shape = "segment"
from_mm = [-1000, 0]
to_mm = [3000, 0]
[[place]]
particle = "ball"
x_mm = 0
z_mm = 10
[run]
duration_s = 0.5
output_interval_s = 0.01
time_step_fraction = 0.1
)");
  SimulationSpec spec;
  spec.scene = datasets::load_scene(file);
  spec.time_step_fraction = 0.1;
  spec.engine_version = embedded_engine().version();
  datasets::ScenePlace& place = spec.scene.places.front();
  place.position.z() = height;
  place.velocity = {velocity, 0.0, 0.0};
  place.angular_velocity = {0.0, spin, 0.0};
  return spec;
}

datasets::Trajectories run(SimulationSpec spec, const datasets::ParameterSet& parameters) {
  datasets::apply_parameters(parameters, spec.scene);
  const EngineRun run = embedded_engine().run(spec, {});
  EXPECT_EQ(run.status, RunStatus::completed) << run.message;
  return run.recording.tracks.value_or(datasets::Trajectories{});
}

// m a = -F,  I alpha = F R - M,  a = R alpha,  M = mu_r R m g,  I = 2/5 m R^2:  a = -5/7 mu_r g
TEST(ParameterEffects, RollingFrictionOnWallsSlowsARollingBall) {
  constexpr double velocity = 0.5, rolling = 0.05, time = 0.4;
  const SimulationSpec spec = ball_on_a_floor(velocity, velocity / radius);
  const auto free = run(spec, {});
  const auto resisted = run(spec, {{"rolling_friction_particle_wall", rolling}});
  const std::size_t frame = 40;
  EXPECT_NEAR(free.poses[frame].x, velocity * time, 1e-4);
  const double deceleration = 5.0 / 7.0 * rolling * gravity;
  EXPECT_NEAR(resisted.poses[frame].x,
              velocity * time - 0.5 * deceleration * time * time,
              0.02 * 0.5 * deceleration * time * time);
  // Between particles it does nothing to a single one
  const auto other = run(spec, {{"rolling_friction_particle_particle", rolling}});
  EXPECT_EQ(other.poses[frame].x, free.poses[frame].x);
}

}  // namespace
}  // namespace graintruth::calibrate
