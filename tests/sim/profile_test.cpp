// Fitting spheres to a profile, and how rough the fitted body is: the thesis's own figures.
#include "sim/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/surface_error.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::number;
using tests::read_rows;
using tests::Row;

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<Row> thesis_rows(const std::string& file) {
  return read_rows(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/thesis" / file);
}

// Ellipse 0.69 x 0.53 cm with eight chords: every digit of profile_fit_7_sphere.csv.
TEST(ProfileFit, SevenSpheresOfTheButton) {
  const ProfileFit fit = fit_profile(ellipse_profile(0.0069, 0.0053), 8);
  const std::vector<Row> rows = thesis_rows("profile_fit_7_sphere.csv");
  ASSERT_EQ(rows.size(), 7u);
  ASSERT_EQ(fit.spheres.size(), 7u);
  EXPECT_NEAR(fit.chord * 100.0, 0.238908, 1e-6);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(fit.spheres[i].radius * 100.0, number(rows[i], "radius_cm"), 1.5e-6);
    EXPECT_NEAR(
        fit.spheres[i].centre.x() * 100.0, number(rows[i], "centre_from_centroid_cm"), 1.5e-6);
  }
  // Spheres inside an ellipse touch it from within
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

// Equation 5.1: the radii of rows of touching spheres with the volume of one of 1 cm.
TEST(ChainOfVolume, RadiiOfTheShapeStudy) {
  for (const Row& row : thesis_rows("eq_5_1_element_radius.csv")) {
    const int count = static_cast<int>(number(row, "aspect_ratio_n"));
    const auto spheres = chain_of_volume(count, count, 4.0 / 3.0 * std::numbers::pi);
    EXPECT_NEAR(spheres[0].radius, number(row, "element_radius_cm"), 6e-6);
  }
}

// Table 3.4, exact column; what the thesis measured in motion stays below the bound.
TEST(SurfaceError, EqualSpheresDeviateByAsinOneOverTwiceTheDensity) {
  for (const Row& row : thesis_rows("table_3_4_pseudo_friction.csv")) {
    const double density = number(row, "sphere_density_q");
    const SurfaceError error = surface_error_of(chain_of_spheres(5, 0.5, 1.0 / density));
    EXPECT_NEAR(error.sphere_density, density, 1e-12);
    EXPECT_NEAR(error.contact_normal / kDegree,
                number(row, "contact_normal_deviation_exact_asin_1_over_2q_deg"),
                1e-4);
    EXPECT_GT(error.pseudo_friction, number(row, "pseudo_friction_mu"));
  }
}

TEST(SurfaceError, ButtonIsRoughestAtItsEquator) {
  const auto spheres = fit_profile(ellipse_profile(0.0069, 0.0053), 8).spheres;
  EXPECT_NEAR(surface_error_of(spheres).contact_normal / kDegree, 2.89, 0.005);
  const auto pair = [&](int i) {
    return contact_normal_error(spheres[i].radius,
                                spheres[i + 1].radius,
                                (spheres[i + 1].centre - spheres[i].centre).norm(),
                                spheres[0].radius) /
           kDegree;
  };
  EXPECT_NEAR(pair(0), 1.62, 0.005);
  EXPECT_NEAR(pair(1), 2.53, 0.005);
}

}  // namespace
}  // namespace graintruth::sim
