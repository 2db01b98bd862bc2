// Parameters that a calibration moves, by what they do to a body of which a closed form is known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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

// A ball that falls from a height h rises to e^2 h.
TEST(ParameterEffects, RestitutionOnWallsDecidesHowHighABallRises) {
  constexpr double height = 0.05, restitution = 0.6;
  const SimulationSpec spec = ball_on_a_floor(0.0, 0.0, radius + height);
  const auto highest_after_landing = [&](const datasets::ParameterSet& parameters) {
    double highest = 0.0;
    const auto tracks = run(spec, parameters);
    for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
      const double landed = std::sqrt(2.0 * height / gravity);  // s
      if (tracks.time[frame] > landed) highest = std::max(highest, tracks.poses[frame].z - radius);
    }
    return highest;
  };
  const double expected = restitution * restitution * height;
  // 10 ms between frames hide at most g (5 ms)^2 / 2, and weight works on a ball that is pressed
  EXPECT_NEAR(
      highest_after_landing({{"restitution", 0.9}, {"restitution_particle_wall", restitution}}),
      expected,
      0.02 * expected);
  EXPECT_NEAR(highest_after_landing({{"restitution", 0.9}}), 0.81 * height, 0.02 * 0.81 * height);
}

// Hertz: a ball rests at m g = 4/3 E* sqrt(R) d^1.5, E* = E / (1 - nu^2).
double overlap_at_rest(double modulus) {
  const double mass = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3) * 1200.0;
  const double stiffness = 4.0 / 3.0 * modulus / (1.0 - 0.3 * 0.3) * std::sqrt(radius);
  return std::pow(mass * gravity / stiffness, 2.0 / 3.0);
}

TEST(ParameterEffects, ElasticModulusDecidesHowDeepABallRests) {
  for (const double modulus : {1e6, 5e7}) {
    const auto tracks = run(ball_on_a_floor(0.0, 0.0), {{"elastic_modulus", modulus}});
    const double overlap = overlap_at_rest(modulus);
    EXPECT_NEAR(tracks.poses.back().z, radius - overlap, 0.02 * overlap) << modulus;
  }
}

// A ball at rest on a floor, pulled along it: it rolls, a = 5/7 g_x, as long as the friction that
// this takes, 2/7 g_x / g_z, is below the static one (twice that where the pull begins at once). If
// not, it slides: a = g_x - mu g_z.
TEST(ParameterEffects, StaticFrictionHoldsABallThatWouldSlide) {
  constexpr double time = 0.2, sliding = 0.05, along = 2.0;  // s, -, m/s2
  constexpr std::size_t frame = 20;
  SimulationSpec spec = ball_on_a_floor(0.0, 0.0, radius - overlap_at_rest(5e7));
  spec.scene.gravity = {along, 0.0, -gravity};
  const auto slides = run(spec, {{"friction_particle_wall", sliding}});
  const auto held =
      run(spec, {{"friction_particle_wall", sliding}, {"static_friction_particle_wall", 0.2}});
  ASSERT_GT(2.0 / 7.0 * along / gravity, sliding);
  ASSERT_LT(2.0 * 2.0 / 7.0 * along / gravity, 0.2);
  EXPECT_NEAR(slides.poses[frame].x, 0.5 * (along - sliding * gravity) * time * time, 2e-4);
  EXPECT_NEAR(held.poses[frame].x, 0.5 * 5.0 / 7.0 * along * time * time, 2e-4);
}

}  // namespace
}  // namespace graintruth::calibrate
