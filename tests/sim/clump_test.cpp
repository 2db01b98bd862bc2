#include "sim/clump.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::outside_reference;
using tests::read_rows;
using tests::Row;

std::vector<ElementSphere> spheres_named(const std::string& name,
                                         const std::filesystem::path& file) {
  std::vector<ElementSphere> spheres;
  for (const Row& row : read_rows(file)) {
    if (row.at("clump") != name) continue;
    spheres.push_back({{number(row, "x"), number(row, "y"), number(row, "z")}, number(row, "r")});
  }
  return spheres;
}

// Volume, centre and sorted principal moments within 1e-9, the tolerance of the reference.
void expect_same(const MassProperties& found, const Row& exact) {
  const double volume = number(exact, "volume");
  EXPECT_NEAR(found.volume / volume, 1.0, 1e-9);
  const Vec3 centre(number(exact, "cx"), number(exact, "cy"), number(exact, "cz"));
  EXPECT_LT((found.centre - centre).norm(), 1e-9);
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(found.inertia).eigenvalues();
  EXPECT_NEAR(moments[0] / number(exact, "I1"), 1.0, 1e-9);
  EXPECT_NEAR(moments[1] / number(exact, "I2"), 1.0, 1e-9);
  EXPECT_NEAR(moments[2] / number(exact, "I3"), 1.0, 1e-9);
}

TEST(ClumpGeometry, BundledShapesAreExact) {
  const auto rows = read_rows(bundled_reference("clump_geometry/mass_properties.csv"));
  ASSERT_EQ(rows.size(), 5u);
  for (const Row& row : rows) {
    SCOPED_TRACE(row.at("clump"));
    const auto spheres =
        spheres_named(row.at("clump"), bundled_reference("clump_geometry/spheres.csv"));
    expect_same(mass_properties_of_union(spheres), row);
  }
}

TEST(ClumpGeometry, ShapesThatAreNotChainsAreExact) {
  const auto rows = read_rows(outside_reference("clump_geometry/mass_properties.csv"));
  if (rows.empty()) GTEST_SKIP() << "reference clump_geometry is not beside the source folder";
  for (const Row& row : rows) {
    SCOPED_TRACE(row.at("clump"));
    expect_same(mass_properties_of_union(spheres_named(
                    row.at("clump"), outside_reference("clump_geometry/spheres.csv"))),
                row);
  }
}

// A tiny sphere inside the chain, off its axis, forces the general method and must not change the result.
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

// Forty copies of a corner of a tetrahedron, each a little displaced inside it, force the even slices.
TEST(ClumpGeometry, ManySpheresAreRightToOnePartInAMillion) {
  std::vector<ElementSphere> spheres = {
      {Vec3(0.5, 0.5, 0.5), 0.8}, {Vec3(-0.5, -0.5, 0.5), 0.8}, {Vec3(-0.5, 0.5, -0.5), 0.8},
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

// Thesis, micro-experiment: R 2.2225, spacing 2.783 cm: 83.528 cm3, I/m 4.2425 and 2.0702 cm2
// (digits as stated).
TEST(ClumpGeometry, MicroBodyOfTheThesis) {
  const Clump clump = make_clump(chain_of_spheres(2, 0.022225, 0.02783), {.mass = 0.142});
  EXPECT_NEAR(clump.volume * 1e6, 83.528, 5e-4);
  EXPECT_NEAR(clump.inertia.y() / clump.mass * 1e4, 4.2425, 5e-5);
  EXPECT_NEAR(clump.inertia.x() / clump.mass * 1e4, 2.0702, 5e-5);
  EXPECT_NEAR(clump.mass / clump.volume, 1700.0, 0.1);
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

TEST(Clump, RefusesWhatIsNotABody) {
  EXPECT_THROW(make_clump({}, {.mass = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_clump({{Vec3::Zero(), 0.0}}, {.mass = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_clump({{Vec3::Zero(), 1.0}}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
