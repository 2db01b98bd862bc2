// Fitting spheres to a profile, and how rough the fitted body is. The thesis's own figures are in
// cases/particle_cases.cpp.
#include "sim/shapes/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/shapes/surface_error.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::number;
using tests::read_rows;
using tests::Row;

std::vector<Row> thesis_rows(const std::string& file) {
  return read_rows(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/thesis" / file);
}

TEST(ProfileFit, SpheresOfTheButtonTouchItFromWithin) {
  const ProfileFit fit = fit_profile(ellipse_profile(0.0069, 0.0053), 8);
  EXPECT_LT(fit.protrusion, 1e-9);
  EXPECT_GT(fit.shortfall, 0.0);
}

// Closed form for an ellipse: c = x (1 - b^2/a^2), r^2 = b^2 (1 - c^2/(a^2 - b^2)).
TEST(ProfileFit, EllipseFromATableIsTheClosedForm) {
  const double a = 2.0, b = 0.7;
  std::vector<ProfilePoint> table;
  for (int i = 0; i <= 16; ++i) {
    const double x = -a * std::cos(std::numbers::pi * i / 16);
    table.push_back({x, i % 16 == 0 ? 0.0 : b * std::sqrt(1.0 - x * x / (a * a))});
  }
  const ProfileFit fit = fit_profile(Profile(table), 14);
  EXPECT_EQ(fit.spheres.size(), 13u);
  for (const ElementSphere& sphere : fit.spheres) {
    const double c = sphere.centre.x();
    EXPECT_NEAR(sphere.radius, b * std::sqrt(1.0 - c * c / (a * a - b * b)), 1e-9);
  }
}

TEST(ProfileFit, ConeTouchesAllItsSpheres) {
  const Profile cone({{0.0, 1.5}, {3.0, 1.0}, {6.0, 0.5}});
  const ProfileFit fit = fit_profile(cone, 10);
  ASSERT_EQ(fit.spheres.size(), 9u);
  // Chords along a straight line: equal steps; tangent to y = 1.5 - x/6
  EXPECT_NEAR(fit.chord, std::hypot(6.0, 1.0) / 10.0, 1e-9);
  for (const ElementSphere& sphere : fit.spheres) {
    const double distance = (1.5 - sphere.centre.x() / 6.0) / std::sqrt(1.0 + 1.0 / 36.0);
    EXPECT_NEAR(sphere.radius, distance, 1e-9);
  }
}

// A waist narrower than the circle that touches it: the sphere sticks out, and that is said.
TEST(ProfileFit, SaysHowFarASphereSticksOut) {
  const Profile step({{0.0, 0.5}, {1.0, 0.5}, {1.1, 1.5}, {2.0, 1.5}});
  EXPECT_GT(fit_profile(step, 12).protrusion, 0.05);
}

TEST(ProfileFit, RefusesWhatIsNoProfile) {
  EXPECT_THROW(Profile({{0, 0}, {1, 1}}), std::invalid_argument);
  EXPECT_THROW(Profile({{0, 0}, {0, 1}, {1, 0}}), std::invalid_argument);
  EXPECT_THROW(Profile({{0, 0}, {1, -1}, {2, 0}}), std::invalid_argument);
  EXPECT_THROW(fit_profile(ellipse_profile(1, 1), 1), std::invalid_argument);
}

TEST(ChainOfVolume, HasItsVolumeAndItsAspectRatio) {
  for (const double aspect : {1.2, 1.6, 2.0}) {
    const auto spheres = chain_of_volume(2, aspect, 4.0);
    EXPECT_NEAR(mass_properties_of_union(spheres).volume, 4.0, 1e-12);
    const double length = 2.0 * spheres[0].radius + spheres[1].centre.x() - spheres[0].centre.x();
    EXPECT_NEAR(length / (2.0 * spheres[0].radius), aspect, 1e-12);
  }
  EXPECT_THROW(chain_of_volume(2, 2.5, 1.0), std::invalid_argument);
}

// Table 3.4: what the thesis measured in motion stays below the bound.
TEST(SurfaceError, BoundsThePseudoFrictionOfTheThesis) {
  for (const Row& row : thesis_rows("table_3_4_pseudo_friction.csv")) {
    const double density = number(row, "sphere_density_q");
    const SurfaceError error = surface_error_of(chain_of_spheres(5, 0.5, 1.0 / density));
    EXPECT_NEAR(error.sphere_density, density, 1e-12);
    EXPECT_GT(error.pseudo_friction, number(row, "pseudo_friction_mu"));
  }
}

}  // namespace
}  // namespace graintruth::sim
