#include "sim/shapes/walls.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "sim/simulation.h"

namespace graintruth::sim {
namespace {

TEST(SegmentWall, IsSeenAtItsFootOrItsEnd) {
  const Wall wall = segment_wall({0.0, 0.0}, {2.0, 0.0});
  EXPECT_DOUBLE_EQ(look_at(wall, {1.0, 5.0, 3.0}).distance, 3.0);
  EXPECT_FALSE(look_at(wall, {1.0, 5.0, 3.0}).is_edge);
  EXPECT_DOUBLE_EQ(look_at(wall, {5.0, 0.0, 4.0}).distance, 5.0);
  EXPECT_TRUE(look_at(wall, {5.0, 0.0, 4.0}).is_edge);
  EXPECT_LT((look_at(wall, {1.0, 0.0, -3.0}).direction - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(PlaneWall, DistanceIsNegativeBehindIt) {
  EXPECT_DOUBLE_EQ(look_at(plane_wall({0.0, 0.0, 1.0}, {0.0, 0.0, 2.0}), {7.0, 0.0, 0.5}).distance,
                   -0.5);
}

// A ball anywhere about a corner where `walls` meet has one contact when only the corner is near,
// and one for each face under which it lies.
int contacts_of_ball_at(const Vec2& centre, const std::vector<Wall>& walls) {
  Scene scene;
  scene.planar = true;
  scene.gravity.setZero();
  scene.add_material({1e9, 0.3});
  const int rigid = scene.add_material(rigid_material());
  scene.add_planar_body(
      scene.add_type(make_clump(chain_of_spheres(1, 1.0, 0.0), {.mass = 1.0})), centre, 0.0);
  for (Wall wall : walls) {
    wall.material = rigid;
    scene.add_wall(wall);
  }
  // Nothing moves: the depth of the contacts does not matter
  return static_cast<int>(Simulation(scene, {.largest_overlap = 1.0}).contacts().size());
}

RC_GTEST_PROP(SegmentWall, ConvexCornerCountsOnce, ()) {
  // Two walls at the throat of the rig: the free side is the outer one
  const std::vector<Wall> walls = {segment_wall({0.0, -5.0}, {0.0, 0.0}),
                                   segment_wall({0.0, 0.0}, {3.0, 5.0})};
  const double angle = *rc::gen::inRange(0, 1000) / 1000.0;
  // Directions to the left of both walls, from just below the horizontal up to the normal of the
  // upper wall
  const double direction = std::numbers::pi * (1.2 - 0.5 * angle);
  const Vec2 centre = 0.97 * Vec2(std::cos(direction), std::sin(direction));
  RC_ASSERT(contacts_of_ball_at(centre, walls) == 1);
  RC_ASSERT(contacts_of_ball_at(centre, {walls[1], walls[0]}) == 1);
}

TEST(MeshWalls, FacetsThatStandInItTwiceAreOne) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
  const MeshWalls mesh = mesh_walls(std::vector<Vec3>{a, b, c, a, c, d, c, a, b, d, c, a}, 7);
  EXPECT_EQ(mesh.facets.size(), 2u);
  EXPECT_EQ(mesh.merged, 2);
  for (const Wall& facet : mesh.facets) EXPECT_EQ(facet.body, 7);
  EXPECT_THROW(mesh_walls(std::vector<Vec3>{a, b, c, a}, 0), std::invalid_argument);
  EXPECT_THROW(mesh_walls(std::vector<Vec3>{a, b, c}, -1), std::invalid_argument);
}

TEST(WallBodies, WallsOfOneNumberLieSideBySide) {
  std::vector<Wall> walls(5, plane_wall(Vec3::Zero(), Vec3::UnitZ()));
  EXPECT_TRUE(bodies_of_walls(walls).are_all_alone);
  walls[1].body = walls[4].body = 3;
  const WallBodies bodies = bodies_of_walls(walls);
  EXPECT_FALSE(bodies.are_all_alone);
  EXPECT_EQ(bodies.of_wall, (std::vector<int>{0, 1, 2, 3, 1}));
  EXPECT_EQ(bodies.order, (std::vector<int>{0, 1, 4, 2, 3}));
  EXPECT_EQ(bodies.rank, (std::vector<int>{0, 1, 3, 4, 2}));
}

TEST(SegmentWall, ConcaveCornerHasTwoFaces) {
  const std::vector<Wall> walls = {segment_wall({0.0, 0.0}, {5.0, 0.0}),
                                   segment_wall({0.0, 0.0}, {0.0, 5.0})};
  EXPECT_EQ(contacts_of_ball_at({0.98, 0.98}, walls), 2);
}

TEST(SegmentWall, PistonEndOnAColumnWallDoesNotCount) {
  // Piston from the column's face at half height; the ball lies above the throat and touches the
  // column's end only
  const std::vector<Wall> walls = {segment_wall({0.0, -5.0}, {0.0, 0.0}),
                                   segment_wall({-3.0, -0.2}, {0.0, -0.2})};
  EXPECT_EQ(contacts_of_ball_at({0.0, 0.97}, walls), 1);
  EXPECT_EQ(contacts_of_ball_at({0.3, 0.6}, walls), 1);
}

}  // namespace
}  // namespace graintruth::sim
