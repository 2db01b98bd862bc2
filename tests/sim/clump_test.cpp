// Clumps of overlapping spheres; what is compared with references is in cases/particle_cases.cpp.
#include "sim/shapes/clump.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

namespace graintruth::sim {
namespace {

// A tiny sphere inside the chain, off its axis, forces the general method and must not change the
// result.
TEST(ClumpGeometry, SlicesAgreeWithPolynomialsOfAChain) {
  auto chain = chain_of_spheres(3, 1.0, 0.7);
  for (ElementSphere& sphere : chain) {
    sphere.centre = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -0.5).normalized()) * sphere.centre;
  }
  const MassProperties exact = mass_properties_of_union(chain);
  chain.push_back({Vec3(0.0, 0.3, 0.2), 1e-3});  // inside the union, off the axis
  const MassProperties sliced = mass_properties_of_union(chain);
  EXPECT_NEAR(sliced.volume / exact.volume, 1.0, 1e-9);
  EXPECT_LT((sliced.centre - exact.centre).norm(), 1e-9);
  EXPECT_LT((sliced.inertia - exact.inertia).norm() / exact.inertia.norm(), 1e-9);
}

// Forty copies of a corner of a tetrahedron, each a little displaced inside it, force the even
// slices.
TEST(ClumpGeometry, ManySpheresAreRightToOnePartInAMillion) {
  std::vector<ElementSphere> spheres = {{Vec3(0.5, 0.5, 0.5), 0.8},
                                        {Vec3(-0.5, -0.5, 0.5), 0.8},
                                        {Vec3(-0.5, 0.5, -0.5), 0.8},
                                        {Vec3(0.5, -0.5, -0.5), 0.8}};
  const MassProperties exact = mass_properties_of_union(spheres);
  for (int i = 0; i < 36; ++i) {
    const Vec3 shift(0.1 * std::cos(i), 0.1 * std::sin(i), 0.002 * i);
    spheres.push_back({spheres[i % 4].centre + shift, 0.65});  // inside its ball of 0.8
  }
  const MassProperties many = mass_properties_of_union(spheres);
  EXPECT_NEAR(many.volume / exact.volume, 1.0, 3e-6);
  EXPECT_LT((many.inertia - exact.inertia).norm(), 3e-6 * exact.inertia.norm());
}

TEST(ClumpGeometry, OneSphereIsABall) {
  const Clump clump = make_clump({{Vec3(1.0, 2.0, 3.0), 0.5}}, {.density = 2.0});
  EXPECT_NEAR(clump.mass, 2.0 * 4.0 / 3.0 * std::numbers::pi * 0.125, 1e-14);
  EXPECT_NEAR(clump.inertia.x(), 0.4 * clump.mass * 0.25, 1e-14);
  EXPECT_LT(clump.spheres.front().centre.norm(), 1e-15);
}

RC_GTEST_PROP(ClumpGeometry, TensorTurnsWithTheShape, ()) {
  const auto part = [] { return *rc::gen::inRange(-1000, 1000) / 1000.0; };
  std::vector<ElementSphere> spheres;
  for (int i = 0; i < 3; ++i) spheres.push_back({Vec3(part(), part(), part()), 0.8 + 0.3 * part()});
  const Quat turn = Quat(1.5, part(), part(), part()).normalized();
  std::vector<ElementSphere> turned = spheres;
  for (ElementSphere& sphere : turned) sphere.centre = turn * sphere.centre;
  const MassProperties a = mass_properties_of_union(spheres);
  const MassProperties b = mass_properties_of_union(turned);
  const Mat3 r = turn.toRotationMatrix();
  RC_ASSERT(std::abs(b.volume / a.volume - 1.0) < 1e-8);
  RC_ASSERT((b.inertia - r * a.inertia * r.transpose()).norm() < 1e-8 * a.inertia.norm());
}

TEST(Clump, BodyFrameIsPrincipal) {
  const Clump clump = make_clump(
      {{Vec3(0.0, -0.41, 0.0), 0.8}, {Vec3(-0.33, 0.19, 0.0), 0.8}, {Vec3(0.29, 0.19, 0.1), 0.7}},
      {.density = 1.0});
  const MassProperties in_body = mass_properties_of_union(clump.spheres);
  EXPECT_LT(in_body.centre.norm(), 1e-9);
  const Mat3 off = in_body.inertia - Mat3(in_body.inertia.diagonal().asDiagonal());
  EXPECT_LT(off.norm(), 1e-8);
  EXPECT_LT((in_body.inertia.diagonal() - clump.inertia).norm(), 1e-8);
}

// Each of two spheres in one place would push.
TEST(Clump, SpheresInOnePlaceAreOne) {
  const ElementSphere left{Vec3(-0.4, 0.0, 0.0), 1.0}, right{Vec3(0.4, 0.0, 0.0), 1.0};
  const ElementSphere hardly_right{Vec3(0.4 + 2e-10, 0.0, 0.0), 1.0};
  const Clump single = make_clump({left, right}, {.density = 1.0});
  const Clump twins = make_clump({left, right, hardly_right, left}, {.density = 1.0});
  EXPECT_EQ(single.merged_spheres, 0);
  EXPECT_EQ(twins.merged_spheres, 2);
  EXPECT_EQ(twins.spheres.size(), 2u);
  EXPECT_DOUBLE_EQ(twins.mass, single.mass);
  // Within each other, but not one
  EXPECT_EQ(make_clump({left, {left.centre, 0.9}}, {.density = 1.0}).spheres.size(), 2u);
}

TEST(Clump, RefusesWhatIsNotABody) {
  EXPECT_THROW(make_clump({}, {.mass = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_clump({{Vec3::Zero(), 0.0}}, {.mass = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_clump({{Vec3::Zero(), 1.0}}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
