// Impacts of single bodies: Hertz's closed form, restitution, and the tests of Chung and Ooi
// (2011).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/simulation.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::outside_reference;
using tests::read_rows;
using tests::Row;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

struct Impact {
  Material material;
  double density, radius, speed;
  Surfaces surfaces = {};
};

// A row of `count` touching balls that falls flat on a rigid plane at z = 0, without gravity.
Scene flat_impact(const Impact& impact, int count, bool planar) {
  Scene scene;
  scene.planar = planar;
  scene.gravity.setZero();
  const int material = scene.add_material(impact.material);
  const int rigid = scene.add_material(rigid_material());
  scene.surfaces.set(material, rigid, impact.surfaces);
  const int type = scene.add_type(make_clump(
      chain_of_spheres(count, impact.radius, 2.0 * impact.radius), {.density = impact.density}));
  scene.add_body(
      type, {0.0, 0.0, impact.radius * (1.0 + 1e-9)}, Quat::Identity(), {0.0, 0.0, -impact.speed});
  scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  return scene;
}

double duration_of(const Scene& scene, int count, double radius, double speed) {
  const double modulus =
      mix(scene.materials[0], scene.materials[1], {}, Tension::allowed, 0.0).normal_modulus;
  return hertz_impact(count * modulus, radius, scene.types[0].mass, speed).duration;
}

double rebound(
    const Impact& impact, int count, SimulationOptions options, bool planar, int steps = 200) {
  const Scene scene = flat_impact(impact, count, planar);
  const double duration = duration_of(scene, count, impact.radius, impact.speed);
  options.time_step.largest = duration / steps;
  options.time_step.fraction = 1.0;
  options.time_step.impact_speed = 1e-6;
  Simulation simulation(scene, options);
  const RunSummary summary = simulation.run_until(3.0 * duration);
  EXPECT_EQ(summary.status, RunStatus::completed) << summary.message;
  EXPECT_TRUE(simulation.contacts().empty());
  return simulation.state().velocity[0].z() / impact.speed;
}

const Impact kAluminiumOxide{{3.8e11, 0.23}, 4000.0, 0.0025, 3.9};

TEST(Restitution, ComesOutAsAskedForAnyNumberOfContacts) {
  for (const Tension tension : {Tension::clipped, Tension::allowed}) {
    for (const int count : {1, 2, 3, 9}) {
      for (const double e : {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}) {
        Impact impact = kAluminiumOxide;
        impact.surfaces.restitution = e;
        // 200 steps per contact, tolerance of the reference table
        EXPECT_NEAR(rebound(impact, count, {.tension = tension}, true), e, 2e-3)
            << count << " contacts, tension "
            << (tension == Tension::clipped ? "clipped" : "allowed");
      }
    }
  }
}

TEST(Restitution, SpaceIsAsTheLayer) {
  Impact impact = kAluminiumOxide;
  impact.surfaces.restitution = 0.6;
  EXPECT_NEAR(rebound(impact, 3, {}, false), 0.6, 2e-3);
}

TEST(Restitution, DoesNotDependOnTheSpeed) {
  Impact impact = kAluminiumOxide;
  impact.surfaces.restitution = 0.5;
  for (const double speed : {0.01, 0.5, 10.0}) {
    impact.speed = speed;
    EXPECT_NEAR(rebound(impact, 1, {}, true), 0.5, 2e-3);
  }
}

// Specification 8: e = 0.72 asked, unclipped law, 1, 2, 3 and 9 contacts. Integrated figures, 2e-3
// as above.
TEST(Restitution, SharingOfDampingFollowsTheDerivedFigures) {
  Impact impact = kAluminiumOxide;
  impact.surfaces.restitution = 0.72;
  const int counts[] = {1, 2, 3, 9};
  const double none[] = {0.720, 0.627, 0.563, 0.356};
  const double inv_n[] = {0.720, 0.793, 0.828, 0.897};
  for (int i = 0; i < 4; ++i) {
    const SimulationOptions a{.tension = Tension::allowed, .damping_sharing = DampingSharing::none};
    const SimulationOptions b{.tension = Tension::allowed,
                              .damping_sharing = DampingSharing::inv_n};
    EXPECT_NEAR(rebound(impact, counts[i], a, true), none[i], 2e-3);
    EXPECT_NEAR(rebound(impact, counts[i], b, true), inv_n[i], 2e-3);
  }
}

TEST(Restitution, ConvergesWithTheTimeStep) {
  Impact impact = kAluminiumOxide;
  impact.surfaces.restitution = 0.5;
  const SimulationOptions options{.tension = Tension::allowed};
  const double coarse = std::abs(rebound(impact, 1, options, true, 50) - 0.5);
  const double fine = std::abs(rebound(impact, 1, options, true, 200) - 0.5);
  EXPECT_LT(fine, 0.25 * coarse);  // a factor 4 in the step: better than first order
}

struct Deepest {
  double overlap = 0.0, force = 0.0, left_at = 0.0;
};

// Parabola through the three largest samples: the peak lies between two steps.
double peak_of(const std::vector<double>& samples) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) k = samples[i] > samples[k] ? i : k;
  const double a = samples[k - 1], b = samples[k], c = samples[k + 1];
  return b - 0.125 * (a - c) * (a - c) / (a - 2.0 * b + c);
}

Deepest follow_impact(const Row& row, int steps_per_contact) {
  const double radius = number(row, "R_m"), speed = number(row, "v_each_ms");
  const double duration = number(row, "t_contact_s");
  const bool pair = row.at("kind") == "pair";
  Scene scene;
  scene.gravity.setZero();
  const int material = scene.add_material({number(row, "E_Pa"), number(row, "nu")});
  const int rigid = scene.add_material(rigid_material());
  const int ball = scene.add_type(
      make_clump(chain_of_spheres(1, radius, 0.0), {.density = number(row, "rho_kgm3")}, material));
  scene.add_body(ball, {0.0, 0.0, radius}, Quat::Identity(), {0.0, 0.0, -speed});
  if (pair) {
    scene.add_body(ball, {0.0, 0.0, -radius}, Quat::Identity(), {0.0, 0.0, speed});
  } else {
    scene.add_wall(plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  }
  SimulationOptions options;
  options.time_step = {
      .fraction = 1.0, .impact_speed = 1e-6, .largest = duration / steps_per_contact};
  Simulation simulation(scene, options);
  std::vector<double> overlap, force;
  Deepest result;
  const auto look = [&](const State& state) {
    const double gap = pair ? state.position[0].z() - state.position[1].z() - 2.0 * radius
                            : state.position[0].z() - radius;
    const auto contacts = simulation.contacts();
    if (overlap.size() > 2 && gap > 0.0 && result.left_at == 0.0) {
      result.left_at = state.time - gap / (pair ? 2.0 * speed : speed);
    }
    overlap.push_back(-gap);
    force.push_back(contacts.empty() ? 0.0 : contacts[0].normal_force);
  };
  simulation.run_until(1.1 * duration,
                       {.interval = duration / steps_per_contact, .observer = look});
  result.overlap = peak_of(overlap);
  result.force = peak_of(force);
  return result;
}

TEST(ChungOoi, Tests1To3AgainstHertz) {
  const auto rows = read_rows(bundled_reference("chung_ooi_impact/hertz_elastic_values.csv"));
  ASSERT_EQ(rows.size(), 3u);
  for (const Row& row : rows) {
    SCOPED_TRACE(row.at("case"));
    const Deepest found = follow_impact(row, 100);
    EXPECT_NEAR(found.overlap / number(row, "delta_max_m"), 1.0, 1e-3);
    EXPECT_NEAR(found.force / number(row, "F_max_N"), 1.0, 1e-3);
    EXPECT_NEAR(found.left_at / number(row, "t_contact_s"), 1.0, 1e-3);
    const Deepest coarse = follow_impact(row, 25), fine = follow_impact(row, 50);
    const double exact = number(row, "t_contact_s");
    const double order =
        std::log2(std::abs(coarse.left_at - exact) / std::abs(fine.left_at - exact));
    EXPECT_GE(order, 1.9);
  }
}

struct Oblique {
  double tangential_restitution, spin, rebound_deg;
};

// Test 4: aluminium oxide at 3.9 m/s, mu 0.092, e 0.98, angle from the normal.
Oblique oblique_impact(double incidence_deg) {
  Impact impact = kAluminiumOxide;
  impact.surfaces = {.friction = 0.092, .restitution = 0.98};
  const double vn = 3.9 * std::cos(incidence_deg * kDegree),
               vt = 3.9 * std::sin(incidence_deg * kDegree);
  impact.speed = vn;
  Scene scene = flat_impact(impact, 1, false);
  scene.bodies[0].velocity.x() = vt;
  const double duration = duration_of(scene, 1, impact.radius, vn);
  SimulationOptions options;
  options.time_step = {.fraction = 1.0, .impact_speed = 1e-6, .largest = duration / 200.0};
  Simulation simulation(scene, options);
  simulation.run_until(1.5 * duration);
  const State& state = simulation.state();
  // Rolling along +x is a positive rotation about +y (z towards x); the paper counts it negative
  const double spin = -state.angular_velocity[0].y();
  const double after = state.velocity[0].x();
  const double patch = std::atan2(after + impact.radius * spin, state.velocity[0].z()) / kDegree;
  return {after / vt, spin, patch};
}

TEST(ChungOoi, Test4GrossSliding) {
  for (const Row& row :
       read_rows(bundled_reference("chung_ooi_impact/test4_gross_sliding_exact.csv"))) {
    if (row.at("regime") != "sliding") continue;
    SCOPED_TRACE(row.at("incidence_deg"));
    const Oblique found = oblique_impact(number(row, "incidence_deg"));
    EXPECT_NEAR(found.tangential_restitution / number(row, "et"), 1.0, 5e-3);
    EXPECT_NEAR(found.spin / number(row, "omega_rad_s"), 1.0, 5e-3);
    // An angle near zero has no relative error of its own: half a percent of the right angle
    EXPECT_NEAR(found.rebound_deg, number(row, "rebound_deg"), 0.45);
  }
}

// The whole range against the digitised curves of the paper; 3 % of the largest value (tolerance of
// the reference).
TEST(ChungOoi, Test4CurvesOfThePaper) {
  const auto compare = [](const std::string& file, const std::string& column, auto value) {
    const auto rows = read_rows(outside_reference("chung_ooi_impact/" + file));
    double largest = 0.0;
    for (const Row& row : rows) {
      if (row.at("set") == "paper_dem_al_oxide")
        largest = std::max(largest, std::abs(number(row, column)));
    }
    for (const Row& row : rows) {
      if (row.at("set") != "paper_dem_al_oxide") continue;
      const double angle = number(row, "incidence_deg");
      EXPECT_NEAR(value(oblique_impact(angle)), number(row, column), 0.03 * largest)
          << file << " at " << angle << " degrees";
    }
    return !rows.empty();
  };
  const bool there =
      compare(
          "test4_angular_velocity.csv", "omega_rad_s", [](const Oblique& o) { return o.spin; }) &&
      compare("test4_rebound_angle.csv",
              "rebound_deg",
              [](const Oblique& o) { return o.rebound_deg; }) &&
      compare("test4_tangential_restitution.csv", "et", [](const Oblique& o) {
        return o.tangential_restitution;
      });
  if (!there) GTEST_SKIP() << "digitised curves of Chung and Ooi are not beside the source folder";
}

TEST(ChungOoi, Test7EqualSurfaceSpeedsChangeNothing) {
  for (const double spin : {0.175, 1.0, 3.464, 22.86}) {
    Scene scene;
    scene.gravity.setZero();
    const int alloy = scene.add_material({7.0e10, 0.33});
    scene.surfaces.set(alloy, alloy, {.friction = 0.4, .restitution = 0.5});
    const int ball = scene.add_type(make_clump(chain_of_spheres(1, 0.1, 0.0), {.density = 2700.0}));
    scene.add_body(ball, {-0.1001, 0.0, 0.0}, Quat::Identity(), {0.2, 0.0, 0.0}, {0.0, spin, 0.0});
    scene.add_body(ball, {0.1001, 0.0, 0.0}, Quat::Identity(), {-0.2, 0.0, 0.0}, {0.0, -spin, 0.0});
    Simulation simulation(scene, {.time_step = {.fraction = 0.1}});
    simulation.run_until(0.003);
    const State& state = simulation.state();
    EXPECT_NEAR(state.velocity[0].x(), -0.1, 1e-3);
    EXPECT_LT(std::abs(state.velocity[0].z()), 0.2e-12);
    EXPECT_LT(std::abs(state.angular_velocity[0].y() - spin), 1e-12 * spin);
    EXPECT_LT(std::abs(state.angular_velocity[1].y() + spin), 1e-12 * spin);
  }
}

}  // namespace
}  // namespace graintruth::sim
