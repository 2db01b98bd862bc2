// Walls in space and walls that move: each against a closed form, or against the plain plane.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/simulation.h"

namespace graintruth::sim {
namespace {

constexpr double kGravity = 9.81;
constexpr double kPi = std::numbers::pi;

// How deep a body of `spheres` equal balls sinks into a rigid floor: (m g / (n k))^(2/3).
double resting_overlap(const Scene& scene, const Clump& clump) {
  const PairMaterial pair =
      mix(scene.materials[0], scene.materials[1], Surfaces{}, Tension::allowed, 0.0);
  const double k = 4.0 / 3.0 * pair.normal_modulus * std::sqrt(clump.spheres.front().radius);
  const double contacts = static_cast<double>(clump.spheres.size());
  return std::pow(clump.mass * kGravity / (contacts * k), 2.0 / 3.0);
}

// A body of the given balls above the origin of an empty rigid world, at rest on z = 0.
Scene at_rest_on_floor(std::vector<ElementSphere> spheres, double friction, bool planar = false) {
  Scene scene;
  scene.planar = planar;
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  scene.add_material({1e8, 0.3});
  scene.add_material(rigid_material());
  scene.surfaces.set(0, 1, {.friction = friction, .restitution = 0.5});
  scene.surfaces.set(0, 0, {.friction = friction, .restitution = 0.5});
  const int type = scene.add_type(make_clump(std::move(spheres), {.density = 1000.0}));
  const double radius = scene.types[type].spheres.front().radius;
  scene.add_body(type, {0.0, 0.0, radius - resting_overlap(scene, scene.types[type])});
  return scene;
}

// Four balls in a square: stands firmly.
std::vector<ElementSphere> table() {
  return {{Vec3(0.02, 0.02, 0.0), 0.01},
          {Vec3(-0.02, 0.02, 0.0), 0.01},
          {Vec3(-0.02, -0.02, 0.0), 0.01},
          {Vec3(0.02, -0.02, 0.0), 0.01}};
}

Wall with_material(Wall wall) {
  wall.material = 1;
  return wall;
}

Wall rectangle(const Vec3& low, const Vec3& high) {
  return with_material(polygon_wall({{low.x(), low.y(), low.z()},
                                     {high.x(), low.y(), low.z()},
                                     {high.x(), high.y(), high.z()},
                                     {low.x(), high.y(), high.z()}}));
}

// A flat floor of triangles with sides of about `edge`, all seams askew to x and y.
std::vector<Wall> triangulated_floor(double edge, int cells) {
  const auto corner = [&](int i, int j) {
    const double x = (i - 0.5 * cells) * edge, y = (j - 0.5 * cells) * edge;
    return Vec3(x + 0.31 * y, y - 0.27 * x, 0.0);
  };
  std::vector<Wall> walls;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      walls.push_back(
          with_material(polygon_wall({corner(i, j), corner(i + 1, j), corner(i, j + 1)})));
      walls.push_back(
          with_material(polygon_wall({corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)})));
    }
  }
  return walls;
}

TEST(Conveyor, BringsABlockToItsSpeedInSpeedOverFrictionTimesGravity) {
  for (const bool planar : {false, true}) {
    const double friction = 0.3, belt = 0.25;
    Scene scene =
        at_rest_on_floor(planar ? chain_of_spheres(5, 0.01, 0.02) : table(), friction, planar);
    Wall wall = planar ? with_material(segment_wall({-1.0, 0.0}, {1.0, 0.0}))
                       : rectangle({-1.0, -1.0, 0.0}, {1.0, 1.0, 0.0});
    wall.drag.velocity = Vec3(belt, 0.0, 0.0);
    scene.add_wall(wall);
    Simulation simulation(scene);
    const double time = belt / (friction * kGravity);
    simulation.run_until(0.5 * time);
    EXPECT_NEAR(simulation.state().velocity[0].x() / (0.5 * belt), 1.0, 0.01);
    simulation.run_until(0.95 * time);
    EXPECT_LT(simulation.state().velocity[0].x(), 0.97 * belt);
    simulation.run_until(1.5 * time);
    EXPECT_NEAR(simulation.state().velocity[0].x() / belt, 1.0, 1e-3);
    // What the belt did is what the block has and what friction took: half each
    EXPECT_NEAR(simulation.state().position[0].z(), 0.01, 1e-4);
  }
}

TEST(Conveyor, WorkIsHalfKineticHalfHeat) {
  const double friction = 0.3, belt = 0.25;
  Scene scene = at_rest_on_floor(table(), friction);
  Wall wall = rectangle({-1.0, -1.0, 0.0}, {1.0, 1.0, 0.0});
  wall.drag.velocity = Vec3(belt, 0.0, 0.0);
  scene.add_wall(wall);
  Simulation simulation(scene, {.tally_work = true});
  simulation.run_until(1.5 * belt / (friction * kGravity));
  const double mass = scene.types[0].mass;
  EXPECT_NEAR(simulation.energy().wall_work / (mass * belt * belt), 1.0, 0.01);
  EXPECT_NEAR(simulation.energy().friction_loss / (0.5 * mass * belt * belt), 1.0, 0.02);
}

// A solid ball that rolls on a turntable goes round in circles with 2/7 of its angular velocity
// (Earnshaw 1844), wherever it starts.
TEST(RotatingDisk, BallGoesRoundAtTwoSeventhsOfItsRate) {
  const double rate = 3.0, radius = 0.01;
  for (const bool wall_turns : {false, true}) {
    Scene scene = at_rest_on_floor({{Vec3::Zero(), radius}}, 0.8);
    Wall disk = with_material(disk_wall(Vec3::Zero(), Vec3::UnitZ(), 1.0));
    (wall_turns ? disk.motion : disk.drag).angular_velocity = Vec3(0.0, 0.0, rate);
    scene.add_wall(disk);
    Body& ball = scene.bodies[0];
    ball.position.x() = 0.2;
    ball.velocity = Vec3(0.05, 0.02, 0.0);
    // No slip: v - R w x z = rate z x r, so R w = z x (v - rate z x r)
    const Vec3 surface = Vec3(0.0, 0.0, rate).cross(ball.position);
    ball.angular_velocity = Vec3::UnitZ().cross(ball.velocity - surface) / radius;
    const double half_period = kPi / (2.0 / 7.0 * rate);
    Simulation simulation(scene);
    simulation.run_until(0.5 * half_period);
    const Vec3 quarter = Vec3::UnitZ().cross(ball.velocity);
    EXPECT_LT((simulation.state().velocity[0] - quarter).norm(), 0.01 * quarter.norm());
    simulation.run_until(half_period);
    EXPECT_LT((simulation.state().velocity[0] + ball.velocity).norm(), 0.01 * ball.velocity.norm());
  }
}

TEST(Mesh, BallRollsOverSeamsAsOnOnePlane) {
  const double radius = 0.01, speed = 0.4;
  Scene on_plane = at_rest_on_floor({{Vec3::Zero(), radius}}, 0.5);
  on_plane.bodies[0].velocity = Vec3(speed, 0.3 * speed, 0.0);
  on_plane.bodies[0].angular_velocity = Vec3::UnitZ().cross(on_plane.bodies[0].velocity) / radius;
  Scene on_mesh = on_plane;
  on_plane.add_wall(with_material(plane_wall(Vec3::Zero(), Vec3::UnitZ())));
  for (const Wall& wall : triangulated_floor(0.013, 26)) on_mesh.add_wall(wall);
  Simulation plane(on_plane), mesh(on_mesh);
  int seen = 0;
  const double start = on_mesh.bodies[0].position.z();
  const Sampling sampling{.interval = 1e-3, .observer = [&](const State& state) {
                            EXPECT_NEAR(state.position[0].z(), start, 1e-10);
                            ++seen;
                          }};
  mesh.run_until(0.3, sampling);
  plane.run_until(0.3);
  EXPECT_EQ(seen, 301);
  EXPECT_LT((mesh.state().position[0] - plane.state().position[0]).norm(), 1e-8);
  EXPECT_LT((mesh.state().velocity[0] - plane.state().velocity[0]).norm(), 1e-7);
  EXPECT_EQ(mesh.contacts().size(), 1u);
}

// With friction at work the spring starts anew on every facet: what that costs is bounded.
TEST(Mesh, BallRollsDownASlopeAlmostAsOnOnePlane) {
  Scene on_plane = at_rest_on_floor({{Vec3::Zero(), 0.01}}, 0.5);
  const double slope = 20.0 * kPi / 180.0;
  on_plane.gravity = kGravity * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  Scene on_mesh = on_plane;
  on_plane.add_wall(with_material(plane_wall(Vec3::Zero(), Vec3::UnitZ())));
  for (const Wall& wall : triangulated_floor(0.006, 42)) on_mesh.add_wall(wall);
  Simulation plane(on_plane), mesh(on_mesh);
  plane.run_until(0.3);
  mesh.run_until(0.3);
  const double speed = plane.state().velocity[0].x();
  EXPECT_NEAR(mesh.state().velocity[0].x() / speed, 1.0, 1e-3);
}

int contacts_with(const std::vector<Wall>& walls, const Vec3& centre, double radius) {
  Scene scene;
  scene.add_material({1e9, 0.3});
  scene.add_material(rigid_material());
  scene.add_body(scene.add_type(make_clump({{Vec3::Zero(), radius}}, {.mass = 1.0})), centre);
  for (const Wall& wall : walls) scene.add_wall(wall);
  return static_cast<int>(Simulation(scene).contacts().size());
}

RC_GTEST_PROP(Mesh, FlatFloorIsOneContactAnywhere, ()) {
  const double x = *rc::gen::inRange(-1000, 1000) * 1e-5;
  const double y = *rc::gen::inRange(-1000, 1000) * 1e-5;
  const double radius = *rc::gen::inRange(1, 60) * 1e-3;  // from smaller to larger than a facet
  RC_ASSERT(contacts_with(triangulated_floor(0.013, 10), {x, y, 0.97 * radius}, radius) == 1);
}

// A roof of two rectangles with its ridge along y, a pyramid's tip, and the inside of a box corner.
TEST(Mesh, RidgeAndTipCountOnceAndAConcaveCornerThreeTimes) {
  const std::vector<Wall> roof = {
      with_material(polygon_wall({{-1, -1, -1}, {0, -1, 0}, {0, 1, 0}, {-1, 1, -1}})),
      with_material(polygon_wall({{0, -1, 0}, {1, -1, -1}, {1, 1, -1}, {0, 1, 0}}))};
  EXPECT_EQ(contacts_with(roof, {0.0, 0.3, 0.49}, 0.5), 1);
  EXPECT_EQ(contacts_with(roof, {0.1, 0.3, 0.48}, 0.5), 1);
  EXPECT_EQ(contacts_with(roof, {-0.9, 0.3, -0.25}, 0.5), 1);
  std::vector<Wall> pyramid;
  const std::vector<Vec3> base = {{1, 1, -1}, {-1, 1, -1}, {-1, -1, -1}, {1, -1, -1}};
  for (int i = 0; i < 4; ++i) {
    pyramid.push_back(with_material(polygon_wall({base[i], base[(i + 1) % 4], Vec3::Zero()})));
  }
  EXPECT_EQ(contacts_with(pyramid, {0.0, 0.0, 0.49}, 0.5), 1);
  EXPECT_EQ(contacts_with(pyramid, {0.01, 0.02, 0.49}, 0.5), 1);
  const std::vector<Wall> corner = {
      rectangle({0, 0, 0}, {2, 2, 0}),
      with_material(polygon_wall({{0, 0, 0}, {0, 2, 0}, {0, 2, 2}, {0, 0, 2}})),
      with_material(polygon_wall({{0, 0, 0}, {0, 0, 2}, {2, 0, 2}, {2, 0, 0}}))};
  EXPECT_EQ(contacts_with(corner, {0.49, 0.49, 0.49}, 0.5), 3);
}

// A ball rolling to and fro in a trough: period 2 pi sqrt(7 (R - r) / (5 g)) (1 + A^2/16 + ...).
TEST(Cylinder, BallInATroughSwingsWithThePeriodOfRolling) {
  const double trough = 0.1, radius = 0.01, amplitude = 0.1;
  for (const bool planar : {true, false}) {
    Scene scene = at_rest_on_floor({{Vec3::Zero(), radius}}, 0.8, planar);
    scene.add_wall(with_material(cylinder_wall({0.0, -1.0, trough}, {0.0, 1.0, trough}, trough)));
    const double reach = trough - scene.bodies[0].position.z();
    scene.bodies[0].position =
        Vec3(reach * std::sin(amplitude), 0.0, trough - reach * std::cos(amplitude));
    const double period = 2.0 * kPi * std::sqrt(7.0 * (trough - radius) / (5.0 * kGravity)) *
                          (1.0 + amplitude * amplitude / 16.0);
    Simulation simulation(scene);
    simulation.run_until(0.25 * period);
    EXPECT_NEAR(simulation.state().position[0].x(), 0.0, 0.01 * reach * amplitude);
    simulation.run_until(period);
    EXPECT_NEAR(simulation.state().position[0].x() / (reach * std::sin(amplitude)), 1.0, 0.01);
  }
}

TEST(Cylinder, IsSeenFromInsideOutsideAndItsRim) {
  const Wall wall = cylinder_wall({0, 0, 0}, {0, 0, 2}, 1.0);
  EXPECT_DOUBLE_EQ(look_at(wall, {0.25, 0, 1}).distance, 0.75);
  EXPECT_LT((look_at(wall, {0.25, 0, 1}).direction - Vec3::UnitX()).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(look_at(wall, {0, 3, 1}).distance, 2.0);
  EXPECT_FALSE(look_at(wall, {0, 3, 1}).is_edge);
  EXPECT_DOUBLE_EQ(look_at(wall, {4, 0, 6}).distance, 5.0);
  EXPECT_TRUE(look_at(wall, {4, 0, 6}).is_edge);
}

TEST(OpeningPanel, LetsGoWhenItOpens) {
  Scene scene = at_rest_on_floor({{Vec3::Zero(), 0.01}}, 0.5);
  Wall panel = rectangle({-0.1, -0.1, 0.0}, {0.1, 0.1, 0.0});
  panel.opens_at = 0.05;
  scene.add_wall(panel);
  Simulation simulation(scene);
  simulation.run_until(0.05);
  EXPECT_LT(simulation.state().velocity[0].norm(), 1e-6);
  simulation.run_until(0.15);
  EXPECT_NEAR(simulation.state().velocity[0].z(), -kGravity * 0.1, 1e-3);
  // The same by hand
  scene.walls[0].opens_at = std::numeric_limits<double>::infinity();
  Simulation by_hand(scene);
  by_hand.run_until(0.05);
  by_hand.open_wall(0, 0.05);
  by_hand.run_until(0.15);
  EXPECT_NEAR(by_hand.state().velocity[0].z(), -kGravity * 0.1, 1e-3);
}

TEST(MovingWall, StopsAtItsEndTime) {
  const Wall wall = plane_wall(
      Vec3::Zero(), Vec3::UnitZ(), {.velocity = {0, 0, 2}, .start_time = 1.0, .end_time = 3.0});
  Wall now = wall;
  place_wall(wall, 2.0, now);
  EXPECT_DOUBLE_EQ(now.point.z(), 2.0);
  place_wall(wall, 9.0, now);
  EXPECT_DOUBLE_EQ(now.point.z(), 4.0);
  EXPECT_DOUBLE_EQ(surface_twist(wall, 2.0).velocity.z(), 2.0);
  EXPECT_DOUBLE_EQ(surface_twist(wall, 9.0).velocity.z(), 0.0);
}

RC_GTEST_PROP(MovingWall, SurfaceVelocityIsTheRateOfItsCorners, ()) {
  const auto part = [] { return *rc::gen::inRange(-1000, 1000) / 1000.0; };
  const auto vector = [&] { return Vec3(part(), part(), part()); };
  Wall wall = polygon_wall({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                           {.velocity = vector(), .angular_velocity = vector(), .pivot = vector()});
  const double time = 0.7, step = 1e-5;
  Wall before = wall, now = wall, after = wall;
  place_wall(wall, time - step, before);
  place_wall(wall, time, now);
  place_wall(wall, time + step, after);
  const Twist twist = surface_twist(wall, time);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 rate = (after.corners[i] - before.corners[i]) / (2.0 * step);
    const Vec3 velocity = twist.velocity + twist.spin.cross(now.corners[i]);
    RC_ASSERT((rate - velocity).norm() < 1e-8);
    RC_ASSERT(velocity.norm() <= fastest_point(wall) + 1e-12);
  }
}

TEST(PolygonWall, RefusesWhatIsNoConvexFlatPatch) {
  EXPECT_THROW(polygon_wall({{0, 0, 0}, {1, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(polygon_wall({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(polygon_wall({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(polygon_wall({{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}}),
               std::invalid_argument);
}

// A block that friction holds on a slope keeps its place when another body is added far away: its
// springs survive.
TEST(AddedBodies, LeaveTheContactsOfTheOthersAlone) {
  Scene scene = at_rest_on_floor(table(), 0.8);
  const double slope = 30.0 * kPi / 180.0;
  scene.gravity = kGravity * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  scene.add_wall(rectangle({-1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}));
  Simulation simulation(scene);
  simulation.run_until(0.1);
  const Vec3 held = simulation.state().position[0];
  simulation.add_bodies({{.type = 0, .position = Vec3(0.5, 0.5, 0.3)}});
  ASSERT_EQ(simulation.state().position.size(), 2u);
  EXPECT_DOUBLE_EQ(simulation.time(), 0.1);
  simulation.run_until(0.12);
  EXPECT_LT((simulation.state().position[0] - held).norm(), 1e-10);
  EXPECT_NEAR(simulation.state().velocity[1].z(), scene.gravity.z() * 0.02, 1e-9);
}

}  // namespace
}  // namespace graintruth::sim
