// Periodic scenes: what happens at the ends of the cell is what happens in its middle.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/engine/periodic_cell.h"
#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

constexpr double radius = 0.01, length = 0.1;  // m

Scene empty_scene(bool planar, const Surfaces& surfaces) {
  Scene scene;
  scene.planar = planar;
  scene.gravity = Vec3::Zero();
  scene.add_material({1e7, 0.3});
  scene.add_material(rigid_material());
  scene.surfaces.set(0, 0, surfaces);
  scene.surfaces.set(0, 1, surfaces);
  return scene;
}

// Balls, or pairs of balls.
int add_grain(Scene& scene, bool is_pair) {
  std::vector<ElementSphere> spheres = {{Vec3::Zero(), radius}};
  if (is_pair)
    spheres = {{Vec3(-0.006, 0.0, 0.0), 0.6 * radius}, {Vec3(0.006, 0.0, 0.0), 0.6 * radius}};
  return scene.add_type(make_clump(spheres, {.density = 1000.0}));
}

// Two grains that meet and part again, moved by `shift`.
State after_meeting(bool planar, bool is_pair, const Vec3& shift, const Period& period) {
  Scene scene =
      empty_scene(planar, {.friction = 0.3, .restitution = 0.7, .rolling_friction = 0.05});
  const int type = add_grain(scene, is_pair);
  const Quat turned = turn_about(Vec3::UnitY(), 0.4);
  scene.add_body(type, shift + Vec3(-0.012, 0.0, 0.003), turned, Vec3(0.4, 0.0, 0.0));
  scene.add_body(type,
                 shift + Vec3(0.012, 0.0, 0.0),
                 Quat::Identity(),
                 Vec3(-0.3, 0.0, 0.0),
                 Vec3(0.0, 9.0, 0.0));
  scene.period = period;
  Simulation simulation(scene, {});
  simulation.run_until(0.03);
  return simulation.state();
}

TEST(Periodic, AMeetingAcrossTheEndIsThatInTheMiddle) {
  const Period period{.low = Vec3(-0.5 * length, -0.5 * length, 0.0),
                      .length = Vec3(length, 0.0, 0.0)};
  for (const bool planar : {true, false}) {
    for (const bool is_pair : {true, false}) {
      const State middle = after_meeting(planar, is_pair, Vec3::Zero(), Period{});
      ASSERT_GT(middle.velocity[1].x(), 0.0);  // they have met
      for (const double where : {0.0, 0.5 * length, 0.45 * length, -0.53 * length}) {
        const State moved = after_meeting(planar, is_pair, Vec3(where, 0.0, 0.0), period);
        for (std::size_t i = 0; i < 2; ++i) {
          EXPECT_LT((moved.velocity[i] - middle.velocity[i]).norm(), 1e-9) << where;
          EXPECT_LT((moved.angular_velocity[i] - middle.angular_velocity[i]).norm(), 1e-7) << where;
          const Vec3 apart = moved.position[i] - middle.position[i] - Vec3(where, 0.0, 0.0);
          EXPECT_LT(nearest(period, apart).norm(), 1e-11) << where;
          EXPECT_LE(std::abs(moved.position[i].x()), 0.5 * length);
        }
      }
    }
  }
}

// Repeats along all its axes.
Scene gas(bool planar, bool is_pair) {
  Scene scene = empty_scene(planar, {.friction = 0.4, .restitution = 0.8});
  const int type = add_grain(scene, is_pair);
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) {
      const double phase = 0.7 * i + 2.1 * k;
      scene.add_body(type,
                     Vec3(0.025 * i, 0.0, 0.025 * k),
                     Quat::Identity(),
                     Vec3(std::sin(phase), 0.0, std::cos(2.0 * phase)),
                     Vec3(0.0, 20.0 * std::cos(phase), 0.0));
    }
  }
  scene.period.length = Vec3(length, planar ? 0.0 : length, length);
  return scene;
}

Vec3 momentum_of(const Simulation& simulation) {
  const Scene now = simulation.scene_now();
  Vec3 sum = Vec3::Zero();
  for (const Body& body : now.bodies) sum += now.types[body.type].mass * body.velocity;
  return sum;
}

TEST(Periodic, KeepsMomentumAndItsAccountOfEnergy) {
  for (const bool planar : {true, false}) {
    for (const bool is_pair : {true, false}) {
      Simulation simulation(gas(planar, is_pair), {.tally_work = true});
      const Energy start = simulation.energy();
      const Vec3 before = momentum_of(simulation);
      const double mass = simulation.scene_now().types[0].mass;
      simulation.run_until(0.2);
      const Energy end = simulation.energy();
      const double lost = end.damping_loss + end.friction_loss;
      EXPECT_GT(lost, 0.5 * start.kinetic);
      EXPECT_LT((momentum_of(simulation) - before).norm(), 1e-12 * mass);
      EXPECT_NEAR(end.total() + lost - start.total(), 0.0, 0.01 * lost);
      for (const Vec3& position : simulation.state().position) {
        for (const int axis : {0, 2}) {
          EXPECT_GE(position[axis], 0.0);
          EXPECT_LE(position[axis], length);
        }
      }
    }
  }
}

TEST(Periodic, GoesOnWithTheSameBitsAndDoesNotDependOnTheSkin) {
  for (const bool planar : {true, false}) {
    const Scene scene = gas(planar, true);
    Simulation whole(scene, {}), wide(scene, {.skin = 0.03});
    whole.run_until(0.03);
    const std::vector<std::byte> bytes = to_bytes(whole.save());
    whole.run_until(0.08);
    Simulation restarted(scene, {});
    restarted.restore(snapshot_from_bytes(bytes));
    restarted.run_until(0.08);
    wide.run_until(0.03);
    wide.run_until(0.08);
    EXPECT_EQ(restarted.state_hash(), whole.state_hash());
    EXPECT_EQ(wide.state_hash(), whole.state_hash());
  }
}

// A chute without an end: gravity is tilted, and a ball that slides without friction is as fast as
// if it fell along the slope. Its weight works all the way, over many periods.
TEST(Periodic, WeightWorksAlongAChuteWithoutAnEnd) {
  Scene scene = empty_scene(false, {.restitution = 0.5});
  const double slope = std::numbers::pi / 6.0;
  scene.gravity = 9.81 * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  scene.add_body(add_grain(scene, false), Vec3(0.05, 0.0, radius));
  Wall floor;
  floor.shape = Wall::Shape::plane;
  floor.point = Vec3::Zero();
  floor.normal = Vec3::UnitZ();
  floor.material = 1;
  scene.add_wall(floor);
  scene.period.length = Vec3(length, 0.0, 0.0);
  Simulation simulation(scene, {.tally_work = true});
  const double before = simulation.energy().total();
  simulation.run_until(0.5);
  const double speed = simulation.state().velocity[0].x();
  EXPECT_NEAR(speed, 9.81 * std::sin(slope) * 0.5, 1e-9);
  const Energy energy = simulation.energy();
  EXPECT_NEAR(energy.total() + energy.damping_loss, before, 1e-4 * energy.kinetic);
  EXPECT_LE(simulation.state().position[0].x(), length);
}

TEST(Periodic, OverlapsAcrossTheEndAreSeenAndRelaxed) {
  Scene scene = empty_scene(false, {});
  const int type = add_grain(scene, false);
  scene.add_body(type, Vec3(0.004, 0.0, 0.0));
  scene.add_body(type, Vec3(0.089, 0.0, 0.0));
  scene.period.length = Vec3(length, 0.0, 0.0);
  EXPECT_NEAR(deepest_overlap(scene), 2.0 * radius - 0.015, 1e-12);
  EXPECT_THROW(Simulation(scene, {}), std::invalid_argument);
  EXPECT_TRUE(relax_overlaps(scene).converged);
  EXPECT_LT(deepest_overlap(scene), 1e-3 * radius);
}

TEST(Periodic, APeriodMustHoldTwoGrains) {
  Scene scene = gas(false, false);
  scene.period.length.y() = 3.9 * radius;
  EXPECT_THROW(check(scene), std::invalid_argument);
  scene.period.length.y() = 4.1 * radius;
  EXPECT_NO_THROW(check(scene));
  scene = gas(true, false);
  scene.period.length.y() = length;
  EXPECT_THROW(check(scene), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
