// Particles: mass properties of overlapping spheres, spheres fitted to a profile, time steps.
#include <Eigen/Eigenvalues>
#include <array>
#include <numbers>

#include "sim/laws/time_step.h"
#include "sim/shapes/profile.h"
#include "sim/shapes/surface_error.h"
#include "tests/sim/cases/check.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim::cases {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::outside_reference;
using tests::read_rows;
using tests::Row;

constexpr double kDegree = std::numbers::pi / 180.0;

// --- Mass properties ---

struct GeometryErrors {
  Worst volume, centre, moments;
  int shapes = 0;
};

GeometryErrors geometry_errors(const std::filesystem::path& folder) {
  GeometryErrors errors;
  for (const Row& exact : read_rows(folder / "mass_properties.csv")) {
    std::vector<ElementSphere> spheres;
    for (const Row& row : read_rows(folder / "spheres.csv")) {
      if (row.at("clump") != exact.at("clump")) continue;
      spheres.push_back({{number(row, "x"), number(row, "y"), number(row, "z")}, number(row, "r")});
    }
    const MassProperties found = mass_properties_of_union(spheres);
    errors.volume.see_ratio(found.volume, number(exact, "volume"));
    const Vec3 centre(number(exact, "cx"), number(exact, "cy"), number(exact, "cz"));
    errors.centre.see((found.centre - centre).norm());
    const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(found.inertia).eigenvalues();
    errors.moments.see_ratio(moments[0], number(exact, "I1"));
    errors.moments.see_ratio(moments[1], number(exact, "I2"));
    errors.moments.see_ratio(moments[2], number(exact, "I3"));
    ++errors.shapes;
  }
  return errors;
}

std::vector<Check> mass_properties() {
  std::vector<Check> checks;
  const auto add = [&](const std::string& which, const std::filesystem::path& folder) {
    const GeometryErrors errors = geometry_errors(folder);
    const std::string source = "clump_geometry, exact";
    if (errors.shapes == 0) {
      checks.push_back(missing(which, source));
      return;
    }
    checks.push_back(within(which + ": volume, relative", source, 1e-9, errors.volume.value));
    checks.push_back(within(which + ": centre of mass, m", source, 1e-9, errors.centre.value));
    checks.push_back(
        within(which + ": principal moments, relative", source, 1e-9, errors.moments.value));
  };
  add("rows of spheres", bundled_reference("clump_geometry"));
  add("all shapes", outside_reference("clump_geometry"));
  return checks;
}

// R 2.2225, spacing 2.783 cm: 83.528 cm3, I/m 4.2425 and 2.0702 cm2.
std::vector<Check> micro_body() {
  const Clump clump = make_clump(chain_of_spheres(2, 0.022225, 0.02783), {.mass = 0.142});
  Worst volume, inertia;
  volume.see(clump.volume * 1e6 - 83.528);
  inertia.see(clump.inertia.y() / clump.mass * 1e4 - 4.2425);
  inertia.see(clump.inertia.x() / clump.mass * 1e4 - 2.0702);
  const std::string source = "model specification 2, digits as stated";
  return {within("volume, cm3", source, 5e-4, volume.value),
          within("I/m, cm2", source, 5e-5, inertia.value)};
}

// --- Profiles ---

std::filesystem::path thesis_file(const std::string& name) {
  return std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/thesis" / name;
}

std::vector<Check> button_of_seven_spheres() {
  const ProfileFit fit = fit_profile(ellipse_profile(0.0069, 0.0053), 8);
  Worst chord, spheres, closed;
  chord.see(fit.chord * 100.0 - 0.238908);
  const std::vector<Row> rows = read_rows(thesis_file("profile_fit_7_sphere.csv"));
  if (rows.size() != fit.spheres.size()) spheres.see(NAN);
  for (std::size_t i = 0; i < std::min(rows.size(), fit.spheres.size()); ++i) {
    const double c = fit.spheres[i].centre.x();
    spheres.see(fit.spheres[i].radius * 100.0 - number(rows[i], "radius_cm"));
    spheres.see(c * 100.0 - number(rows[i], "centre_from_centroid_cm"));
    // r^2 = b^2 (1 - c^2/(a^2 - b^2))
    const double a = 0.0069, b = 0.0053;
    closed.see_ratio(fit.spheres[i].radius, b * std::sqrt(1.0 - c * c / (a * a - b * b)));
  }
  const std::string source = "model specification 1, digits as stated";
  return {within("chord, cm", source, 1e-6, chord.value),
          within("radii and centres of the seven spheres, cm", source, 1.5e-6, spheres.value),
          within("radii against the closed form of the ellipse, relative",
                 "model specification 1",
                 1e-9,
                 closed.value)};
}

std::vector<Check> roughness() {
  Worst equal, radii;
  for (const Row& row : read_rows(thesis_file("table_3_4_pseudo_friction.csv"))) {
    const double density = number(row, "sphere_density_q");
    const SurfaceError error = surface_error_of(chain_of_spheres(5, 0.5, 1.0 / density));
    equal.see(error.contact_normal / kDegree -
              number(row, "contact_normal_deviation_exact_asin_1_over_2q_deg"));
  }
  for (const Row& row : read_rows(thesis_file("eq_5_1_element_radius.csv"))) {
    const int count = static_cast<int>(number(row, "aspect_ratio_n"));
    radii.see(chain_of_volume(count, count, 4.0 / 3.0 * std::numbers::pi)[0].radius -
              number(row, "element_radius_cm"));
  }
  const auto spheres = fit_profile(ellipse_profile(0.0069, 0.0053), 8).spheres;
  Worst button;
  const std::array printed = {1.62, 2.53, 2.89};
  for (std::size_t i = 0; i < printed.size(); ++i) {
    button.see(contact_normal_error(spheres[i].radius,
                                    spheres[i + 1].radius,
                                    (spheres[i + 1].centre - spheres[i].centre).norm(),
                                    spheres[0].radius) /
                   kDegree -
               printed[i]);
  }
  return {
      within(
          "equal spheres: asin(1/2q), degrees", "thesis table 3.4, errata 33", 1e-4, equal.value),
      within("button: 1.62, 2.53, 2.89 degrees", "errata 35, digits as stated", 5e-3, button.value),
      within("rows with the volume of one ball: radii, cm",
             "thesis 5.1, digits as stated",
             6e-6,
             radii.value)};
}

std::vector<Check> time_steps() {
  const Material button{3.5e9, 0.30};
  const double one_cm = rayleigh_time_step(0.01, 1256.4, button) / std::numbers::pi;
  const double small = rayleigh_time_step(0.00433, 1256.4, button) / std::numbers::pi;
  return {within("1.044e-5 s for 1 cm, s",
                 "errata 1, digits as stated",
                 5e-9,
                 std::abs(one_cm - 1.044e-5)),
          within("8850 steps a frame of 0.04 s, steps",
                 "model specification 11",
                 10.0,
                 std::abs(0.04 / small - 8850.0))};
}

constexpr std::array kCases = {
    Case{"MassProperties", "Mass, centre and inertia of overlapping spheres", mass_properties},
    Case{"MicroBody", "The body of the micro-experiment", micro_body},
    Case{"ButtonOfSevenSpheres", "Seven spheres in an ellipse", button_of_seven_spheres},
    Case{"Roughness", "Contact normals of bodies of spheres", roughness},
    Case{"TimeSteps", "The thesis's time steps", time_steps}};

}  // namespace

std::span<const Case> particle_cases() { return kCases; }

}  // namespace graintruth::sim::cases
