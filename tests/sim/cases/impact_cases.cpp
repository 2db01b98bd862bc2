// Impacts of single bodies: Hertz's closed form, restitution on one and on several contacts, and
// the tests of Chung and Ooi (2011).
#include <array>
#include <numbers>

#include "sim/laws/restitution.h"
#include "sim/simulation.h"
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

const std::string kChungOoi = "Chung and Ooi 2011";
const std::string kDamped = "damped_hertz_restitution";

struct Impact {
  Material material;
  double density, radius, speed;
  Surfaces surfaces = {};
};
const Impact kAluminiumOxide{{3.8e11, 0.23}, 4000.0, 0.0025, 3.9};

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

double elastic_duration(const Scene& scene, int count, const Impact& impact) {
  const double modulus =
      mix(scene.materials[0], scene.materials[1], {}, Tension::allowed, 0.0).normal_modulus;
  return hertz_impact(count * modulus, impact.radius, scene.types[0].mass, impact.speed).duration;
}

// Steps of exactly this length as far as it divides the time.
TimeStepOptions steps_of(double time_step) {
  return {.fraction = 1.0, .impact_speed = 1e-6, .largest = time_step};
}

// Rebound speed over impact speed at `steps` steps per elastic contact. NaN when the run went
// wrong.
double rebound(const Impact& impact,
               int count,
               SimulationOptions options,
               bool planar = true,
               int steps = 200) {
  const Scene scene = flat_impact(impact, count, planar);
  const double duration = elastic_duration(scene, count, impact);
  options.time_step = steps_of(duration / steps);
  Simulation simulation(scene, options);
  const RunSummary summary = simulation.run_until(3.0 * duration);
  if (summary.status != RunStatus::completed || !simulation.contacts().empty()) return NAN;
  return simulation.state().velocity[0].z() / impact.speed;
}

Impact with_restitution(Impact impact, double e) {
  impact.surfaces.restitution = e;
  return impact;
}

// --- Elastic impacts ---

// What a look at every step finds of an elastic impact of one ball on a plane, or of two balls.
struct ImpactCurve {
  std::vector<double> time, overlap, force;  // s, m, N
  double left_at = 0.0;                      // s; when the surfaces part
};

ImpactCurve follow_impact(const Row& row, int steps_per_contact) {
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
  const double time_step = duration / steps_per_contact;
  Simulation simulation(scene, {.time_step = steps_of(time_step)});
  ImpactCurve curve;
  const auto look = [&](const State& state) {
    const double gap = pair ? state.position[0].z() - state.position[1].z() - 2.0 * radius
                            : state.position[0].z() - radius;
    const auto contacts = simulation.contacts();
    if (curve.time.size() > 2 && gap > 0.0 && curve.left_at == 0.0) {
      curve.left_at = state.time - gap / (pair ? 2.0 * speed : speed);
    }
    curve.time.push_back(state.time);
    curve.overlap.push_back(-gap);
    curve.force.push_back(contacts.empty() ? 0.0 : contacts[0].normal_force);
  };
  simulation.run_until(1.1 * duration, {.interval = time_step, .observer = look});
  return curve;
}

// Parabola through the three largest samples: the peak lies between two steps.
double peak_of(const std::vector<double>& samples) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) k = samples[i] > samples[k] ? i : k;
  const double a = samples[k - 1], b = samples[k], c = samples[k + 1];
  return b - 0.125 * (a - c) * (a - c) / (a - 2.0 * b + c);
}

std::vector<Check> elastic_impacts() {
  std::vector<Check> checks;
  for (const Row& row : read_rows(bundled_reference("chung_ooi_impact/hertz_elastic_values.csv"))) {
    const std::string name = row.at("case") + ": ";
    const double duration = number(row, "t_contact_s");
    const ImpactCurve curve = follow_impact(row, 100);
    Worst overlap, force, time;
    overlap.see_ratio(peak_of(curve.overlap), number(row, "delta_max_m"));
    force.see_ratio(peak_of(curve.force), number(row, "F_max_N"));
    time.see_ratio(curve.left_at, duration);
    const std::string source = kChungOoi + ", exact Hertz, t_c/100";
    checks.push_back(within(name + "deepest overlap, relative", source, 1e-3, overlap.value));
    checks.push_back(within(name + "largest force, relative", source, 1e-3, force.value));
    checks.push_back(within(name + "duration, relative", source, 1e-3, time.value));
    const double coarse = follow_impact(row, 25).left_at, fine = follow_impact(row, 50).left_at;
    checks.push_back(order_of(name + "order of accuracy in the time step",
                              "validation plan 2",
                              1.9,
                              observed_order(coarse - duration, fine - duration)));
  }
  return checks;
}

// The value of a curve at x, between the samples [from, to); x ascends or descends along them.
double along(const std::vector<double>& x,
             const std::vector<double>& y,
             std::size_t from,
             std::size_t to,
             double at) {
  for (std::size_t i = from; i + 1 < to; ++i) {
    if ((x[i] - at) * (x[i + 1] - at) <= 0.0 && x[i] != x[i + 1]) {
      return y[i] + (y[i + 1] - y[i]) * (at - x[i]) / (x[i + 1] - x[i]);
    }
  }
  return 0.0;
}

// Distance of the digitised points from the simulated curve, over the largest force.
std::vector<Check> published_force_curves() {
  const std::string source = kChungOoi + ", digitised";
  const auto exact = read_rows(bundled_reference("chung_ooi_impact/hertz_elastic_values.csv"));
  std::vector<Check> checks;
  const std::array names = {"test1_glass", "test2_al_alloy"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = names[i];
    const std::string folder = "chung_ooi_impact/" + name;
    const ImpactCurve curve = follow_impact(exact[i], 400);
    const double largest = peak_of(curve.force);
    const std::size_t turn = static_cast<std::size_t>(
        std::max_element(curve.overlap.begin(), curve.overlap.end()) - curve.overlap.begin());
    const auto against_time = read_rows(outside_reference(folder + "_force_vs_time.csv"));
    const auto against_overlap = read_rows(outside_reference(folder + "_force_vs_overlap.csv"));
    const std::string of_time = name + ": force against time, of the largest";
    const std::string of_overlap = name + ": force against overlap, of the largest";
    if (against_time.empty() || against_overlap.empty()) {
      checks.push_back(missing(of_time, source));
      checks.push_back(missing(of_overlap, source));
      continue;
    }
    Worst time, overlap;
    for (const Row& row : against_time) {
      const double found =
          along(curve.time, curve.force, 0, curve.time.size(), 1e-6 * number(row, "time_us"));
      time.see((found - 1e3 * number(row, "force_kN")) / largest);
    }
    for (const Row& row : against_overlap) {
      // Beyond the deepest overlap the nearest point of the curve is its tip
      const double at = std::min(1e-6 * number(row, "overlap_um"), curve.overlap[turn]);
      const double found = along(curve.overlap, curve.force, 0, turn + 1, at);
      overlap.see((found - 1e3 * number(row, "force_kN")) / largest);
    }
    checks.push_back(within(of_time, source, 0.02, time.value));
    checks.push_back(within(of_overlap, source, 0.02, overlap.value));
  }
  return checks;
}

// --- Restitution ---

std::vector<Check> restitution_of_test_3() {
  Worst worst;
  for (const double e : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    worst.see(rebound(with_restitution(kAluminiumOxide, e), 1, {}, false) - e);
  }
  return {within(
      "test 3: e = 0.2 ... 1, ends at zero overlap, absolute", kChungOoi, 0.005, worst.value)};
}

// When an unclipped contact ends, s, and its deepest overlap, m.
struct DampedImpact {
  double left_at = 0.0, deepest = 0.0;
};
DampedImpact follow_damped(double e) {
  const Impact impact = with_restitution(kAluminiumOxide, e);
  Scene scene = flat_impact(impact, 1, false);
  scene.bodies[0].position.z() = impact.radius;
  const double duration = elastic_duration(scene, 1, impact);
  Simulation simulation(scene,
                        {.time_step = steps_of(duration / 200.0), .tension = Tension::allowed});
  std::vector<double> overlap;
  DampedImpact result;
  const auto look = [&](const State& state) {
    const double gap = state.position[0].z() - impact.radius;
    if (overlap.size() > 2 && gap > 0.0 && result.left_at == 0.0) {
      result.left_at = state.time - gap / state.velocity[0].z();
    }
    overlap.push_back(-gap);
  };
  simulation.run_until(2.0 * duration, {.interval = duration / 200.0, .observer = look});
  result.deepest = peak_of(overlap);
  return result;
}

std::vector<Check> damped_hertz() {
  const Scene scene = flat_impact(kAluminiumOxide, 1, false);
  const double duration = elastic_duration(scene, 1, kAluminiumOxide);
  const double modulus =
      mix(scene.materials[0], scene.materials[1], {}, Tension::allowed, 0.0).normal_modulus;
  const double deepest =
      hertz_impact(modulus, kAluminiumOxide.radius, scene.types[0].mass, kAluminiumOxide.speed)
          .deepest_overlap;
  Worst pulling, clipped, ratio, time, overlap;
  for (const Row& row :
       read_rows(bundled_reference("damped_hertz_restitution/restitution_table.csv"))) {
    const double e = number(row, "e_input");
    if (e < 0.2) continue;  // no tolerance is stated for them
    const double without_pull = number(row, "e_out_no_attraction");
    pulling.see(rebound(with_restitution(kAluminiumOxide, e), 1, {.tension = Tension::allowed}) -
                number(row, "e_out_full_overlap"));
    clipped.see(rebound(with_restitution(kAluminiumOxide, without_pull), 1, {}) - without_pull);
    ratio.see(damping_ratio_for(without_pull, Tension::clipped) - number(row, "beta"));
    const DampedImpact impact = follow_damped(e);
    time.see_ratio(impact.left_at / duration, number(row, "t_contact_ratio"));
    overlap.see_ratio(impact.deepest / deepest, number(row, "delta_max_ratio"));
  }
  const std::string steps = ", e >= 0.2, t_c/200";
  return {
      within("contact may pull: rebound, absolute", kDamped + steps, 2e-3, pulling.value),
      within("contact may not pull: rebound, absolute", kDamped + steps, 2e-3, clipped.value),
      within("contact may not pull: damping ratio, absolute", kDamped + steps, 2e-3, ratio.value),
      within("duration over the elastic one, relative", kDamped + steps, 2e-3, time.value),
      within(
          "deepest overlap over the elastic one, relative", kDamped + steps, 2e-3, overlap.value)};
}

std::vector<Check> coincident_contacts() {
  std::vector<Check> checks;
  for (int count = 1; count <= 9; ++count) {
    Worst worst;
    for (const Tension tension : {Tension::clipped, Tension::allowed}) {
      for (const double e : {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}) {
        worst.see(rebound(with_restitution(kAluminiumOxide, e), count, {.tension = tension}) - e);
      }
    }
    checks.push_back(within(std::to_string(count) + (count == 1 ? " contact" : " contacts") +
                                ": e = 0.2 ... 1, with and without pull, absolute",
                            "issue 3; tolerance of " + kDamped,
                            2e-3,
                            worst.value));
  }
  Worst space;
  space.see(rebound(with_restitution(kAluminiumOxide, 0.6), 3, {}, false) - 0.6);
  checks.push_back(within("3 contacts in space: e = 0.6, absolute", kDamped, 2e-3, space.value));
  Worst speeds;
  for (const double speed : {0.01, 0.5, 10.0}) {
    Impact impact = with_restitution(kAluminiumOxide, 0.5);
    impact.speed = speed;
    speeds.see(rebound(impact, 1, {}) - 0.5);
  }
  checks.push_back(
      within("e = 0.5 at 0.01, 0.5 and 10 m/s, absolute", kDamped, 2e-3, speeds.value));
  return checks;
}

std::vector<Check> sharing_of_damping() {
  struct Sharing {
    DampingSharing how;
    const char* name;
    std::array<double, 4> rebound;
  };
  const std::array counts = {1, 2, 3, 9};
  const std::array sharings = {
      Sharing{DampingSharing::inv_sqrt_n, "c/sqrt(N)", {0.720, 0.720, 0.720, 0.720}},
      Sharing{DampingSharing::none, "c", {0.720, 0.627, 0.563, 0.356}},
      Sharing{DampingSharing::inv_n, "c/N", {0.720, 0.793, 0.828, 0.897}}};
  std::vector<Check> checks;
  for (const Sharing& sharing : sharings) {
    Worst worst;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const SimulationOptions options{.tension = Tension::allowed, .damping_sharing = sharing.how};
      worst.see(rebound(with_restitution(kAluminiumOxide, 0.72), counts[i], options) -
                sharing.rebound[i]);
    }
    checks.push_back(within(
        std::string("dashpots ") + sharing.name + ": e = 0.72 on 1, 2, 3, 9 contacts, absolute",
        "thesis 3.4, model specification 8; tolerance of " + kDamped,
        2e-3,
        worst.value));
  }
  return checks;
}

// --- Oblique impacts ---

struct Oblique {
  double tangential_restitution, spin, rebound_deg;
};

// Test 4: aluminium oxide at 3.9 m/s, mu 0.092, e 0.98, angle from the normal; or `stiffer` than
// it.
Oblique oblique_impact(double incidence_deg, double stiffer = 1.0) {
  Impact impact = kAluminiumOxide;
  impact.material.youngs_modulus *= stiffer;
  impact.surfaces = {.friction = 0.092, .restitution = 0.98};
  const double vn = 3.9 * std::cos(incidence_deg * kDegree),
               vt = 3.9 * std::sin(incidence_deg * kDegree);
  impact.speed = vn;
  Scene scene = flat_impact(impact, 1, false);
  scene.bodies[0].velocity.x() = vt;
  const double duration = elastic_duration(scene, 1, impact);
  Simulation simulation(scene, {.time_step = steps_of(duration / 200.0)});
  simulation.run_until(1.5 * duration);
  const State& state = simulation.state();
  // Rolling along +x is a positive rotation about +y (z towards x); the paper counts it negative
  const double spin = -state.angular_velocity[0].y();
  const double after = state.velocity[0].x();
  const double patch = std::atan2(after + impact.radius * spin, state.velocity[0].z()) / kDegree;
  return {after / vt, spin, patch};
}

std::vector<Check> gross_sliding() {
  const std::string source = kChungOoi + ", exact for rigid balls";
  std::vector<Check> checks;
  Worst of_largest;
  for (const double stiffer : {1.0, 100.0}) {
    Worst restitution, spin, angle;
    for (const Row& row :
         read_rows(bundled_reference("chung_ooi_impact/test4_gross_sliding_exact.csv"))) {
      if (row.at("regime") != "sliding") continue;
      const Oblique found = oblique_impact(number(row, "incidence_deg"), stiffer);
      const double exact_deg = number(row, "rebound_deg");
      restitution.see_ratio(found.tangential_restitution, number(row, "et"));
      spin.see_ratio(found.spin, number(row, "omega_rad_s"));
      angle.see_ratio(found.rebound_deg, exact_deg);
      if (stiffer == 1.0) of_largest.see((found.rebound_deg - exact_deg) / 84.8116);
    }
    const std::string name =
        stiffer == 1.0 ? "test 4, 35 ... 85 degrees: " : "the same, a hundred times as stiff: ";
    checks.push_back(
        within(name + "tangential restitution, relative", source, 5e-3, restitution.value));
    checks.push_back(within(name + "spin, relative", source, 5e-3, spin.value));
    if (stiffer == 1.0) {
      checks.push_back(
          within(name + "rebound angle, of the largest", source, 5e-3, of_largest.value));
    } else {
      checks.push_back(within(name + "rebound angle, relative", source, 5e-3, angle.value));
    }
  }
  return checks;
}

// Deviation from the digitised curve of one quantity, over its largest value.
std::vector<Check> published_curve(const std::string& file,
                                   const std::string& column,
                                   const std::string& name,
                                   double Oblique::*quantity) {
  constexpr double kSlidesFrom = 33.0;  // degrees; below, the contact sticks for a while
  const std::string source = kChungOoi + ", digitised";
  const auto rows = read_rows(outside_reference("chung_ooi_impact/" + file));
  const std::string sticks = "test 4: " + name + ", below 33 degrees, of the largest";
  const std::string slides = "test 4: " + name + ", above, of the largest";
  if (rows.empty()) return {missing(sticks, source), missing(slides, source)};
  double largest = 0.0;
  for (const Row& row : rows) {
    if (row.at("set") == "paper_dem_al_oxide") {
      largest = std::max(largest, std::abs(number(row, column)));
    }
  }
  Worst below, above;
  for (const Row& row : rows) {
    if (row.at("set") != "paper_dem_al_oxide") continue;
    const double angle = number(row, "incidence_deg");
    const double error = (oblique_impact(angle).*quantity - number(row, column)) / largest;
    (angle < kSlidesFrom ? below : above).see(error);
  }
  return {within(sticks, source, 0.03, below.value), within(slides, source, 0.02, above.value)};
}

std::vector<Check> curves_of_test_4() {
  std::vector<Check> checks;
  const auto add = [&](std::vector<Check> more) {
    checks.insert(checks.end(), more.begin(), more.end());
  };
  add(published_curve("test4_angular_velocity.csv", "omega_rad_s", "spin", &Oblique::spin));
  add(published_curve(
      "test4_rebound_angle.csv", "rebound_deg", "rebound angle", &Oblique::rebound_deg));
  add(published_curve("test4_tangential_restitution.csv",
                      "et",
                      "tangential restitution",
                      &Oblique::tangential_restitution));
  return checks;
}

// Test 7: two equal balls whose surfaces do not slip, so every spin must stay. Those of the
// reference, and some that are always at hand.
std::vector<Check> equal_surface_speeds() {
  std::vector<double> all_spins = {0.175, 1.0, 3.464, 22.86};
  for (const Row& row :
       read_rows(outside_reference("chung_ooi_impact/test7_two_equal_spheres_spin.csv"))) {
    all_spins.push_back(number(row, "omega0_rad_s"));
  }
  Worst velocity, spins;
  for (const double spin : all_spins) {
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
    if (!(state.velocity[0].x() < 0.0)) velocity.see(NAN);  // they must have rebounded
    velocity.see(state.velocity[0].z() / 0.2);
    spins.see_ratio(state.angular_velocity[0].y(), spin);
    spins.see_ratio(state.angular_velocity[1].y(), -spin);
  }
  return {
      within("test 7: tangential velocity, of the impact speed", kChungOoi, 1e-12, velocity.value),
      within("test 7: spin, relative", kChungOoi, 1e-12, spins.value)};
}

// --- Others ---

// Dosta et al. 2024: M1 on steel.
std::vector<Check> open_dem_impact() {
  const Impact impact{{1.0e9, 0.2}, 2500.0, 0.001, 1.0, {.friction = 0.2, .restitution = 0.4}};
  Scene scene = flat_impact(impact, 1, false);
  scene.materials[1] = {2.1e11, 0.2};
  Simulation simulation(scene, {.time_step = steps_of(5e-7)});
  simulation.run_until(1e-4);
  return {within("M1 ball on steel at 1 m/s, dt 5e-7 s: e = 0.4, absolute",
                 "Dosta et al. 2024, self test a; tolerance of test 3",
                 0.005,
                 simulation.state().velocity[0].z() - 0.4)};
}

// Thesis 3.3: 2 m v of an elastic rebound; at a fraction of the thesis's own critical step, over
// starts that differ by parts of a step.
std::vector<Check> impulse_of_the_thesis() {
  constexpr double kMass = 0.2105 / 9.81, kCriticalStep = 1.044e-5, kSpeed = 1.0;
  const Material button{3.5e9, 0.3};
  std::vector<Check> checks;
  const auto worst_at = [&](double fraction) {
    Worst worst;
    const double step = fraction * kCriticalStep;
    for (int phase = 0; phase < 8; ++phase) {
      Scene scene = flat_impact({button, 1256.4, 0.01, kSpeed}, 1, true);
      scene.types[0] = make_clump(chain_of_spheres(1, 0.01, 0.0), {.mass = kMass});
      scene.bodies[0].position.z() = 0.01 + (1.0 + phase / 8.0) * step * kSpeed;
      Simulation simulation(scene, {.time_step = steps_of(step)});
      simulation.run_until(1e-3);
      worst.see(0.5 * (simulation.state().velocity[0].z() / kSpeed - 1.0));
    }
    return worst.value;
  };
  const double whole = worst_at(1.0);
  checks.push_back(within("impulse of an elastic rebound at frac 1, relative",
                          "thesis fig. 3.5, model specification 10",
                          2.8e-3,
                          whole));
  checks.push_back(within("impulse of an elastic rebound at frac 0.5, relative",
                          "thesis fig. 3.5, model specification 10",
                          7e-4,
                          worst_at(0.5)));
  checks.push_back(within(
      "energy of the rebound at frac 1, relative", "model specification 10", 5e-3, 4.0 * whole));
  return checks;
}

// Thornton, Cummins and Cleary 2013: R = 25 mm, mu = 0.1, 5 m/s across a rigid plane, at the angle
// of theta = 2 tan/(mu (1 + e)). Tangential restitution.
double thornton_restitution(double e, double theta, TangentialSpring law) {
  constexpr double kFriction = 0.1;
  const Impact impact{{7e10, 0.3}, 2650.0, 0.025, 5.0, {.friction = kFriction, .restitution = e}};
  Scene scene = flat_impact(impact, 1, true);
  const double along = 0.5 * theta * kFriction * (1.0 + e) * impact.speed;
  scene.bodies[0].velocity.x() = along;
  const double duration = elastic_duration(scene, 1, impact);
  Simulation simulation(scene, {.time_step = steps_of(duration / 200.0), .tangential_spring = law});
  simulation.run_until(2.0 * duration);
  return simulation.state().velocity[0].x() / along;
}

std::vector<Check> thornton_curves() {
  const std::string source = "Thornton et al. 2013, digitised; law mindlin_scaled";
  const auto rows = read_rows(outside_reference("thornton_oblique_restitution/oblique_impact.csv"));
  std::vector<Check> checks;
  for (const auto& [set, e] :
       {std::pair("et_hertz_e0.50", 0.5), std::pair("et_hertz_e0.90", 0.9)}) {
    const std::string what = std::string("e = ") + (e == 0.5 ? "0.5" : "0.9") +
                             ": tangential restitution, of the largest";
    if (rows.empty()) {
      checks.push_back(missing(what, source));
      continue;
    }
    Worst worst;
    double largest = 0.0;
    for (const Row& row : rows) {
      if (row.at("set") == set) largest = std::max(largest, number(row, "value"));
    }
    for (const Row& row : rows) {
      if (row.at("set") != set) continue;
      const double found =
          thornton_restitution(e, number(row, "theta_norm"), TangentialSpring::mindlin_scaled);
      worst.see((found - number(row, "value")) / largest);
    }
    checks.push_back(within(what, source, 0.05, worst.value));
  }
  return checks;
}

constexpr std::array kCases = {
    Case{"ThorntonCurves",
         "Oblique impact with restitution: published curves",
         thornton_curves,
         "By `mindlin_scaled`, since these curves are of a spring that keeps its force while the "
         "pressure grows,\n"
         "as contact mechanics without slip asks. `mindlin` gives 0.91 where 0.82 is published, at "
         "e = 0.9 and\n"
         "small angles. Test 4 of Chung and Ooi below is by `mindlin`, the spring of the codes "
         "that it is from:\n"
         "`mindlin_scaled` lies up to 9 % of the largest beside it there, but nearer to the "
         "experiment that they\n"
         "show with it, 0.80 and 0.75 at 2 and 4 degrees."},
    Case{"ElasticImpacts", "Elastic impact: Hertz's closed form", elastic_impacts},
    Case{"PublishedForceCurves", "Elastic impact: published curves", published_force_curves},
    Case{"RestitutionOfTest3", "Restitution asked and given", restitution_of_test_3},
    Case{"DampedHertz", "Damped Hertz contact", damped_hertz},
    Case{"CoincidentContacts", "Restitution on 1 to 9 contacts at once", coincident_contacts},
    Case{"SharingOfDamping", "Sharing the damping of contacts", sharing_of_damping},
    Case{"GrossSliding",
         "Oblique impact that slides throughout",
         gross_sliding,
         "The exact values are those of rigid balls. Ours is flattened by up to 0.3 % of its "
         "radius, so friction\n"
         "turns it by a lever that is shorter by half of that: the spin is 0.1 % low. At 35 "
         "degrees, where the\n"
         "rebound angle is the small difference of two speeds (3.66 degrees), that is 0.03 "
         "degrees, or 0.8 % of it;\n"
         "a hundred times as stiff a ball has what is stated, relative to the angle itself."},
    Case{"CurvesOfTest4", "Oblique impact: published curves", curves_of_test_4},
    Case{"EqualSurfaceSpeeds", "Impact of balls that roll on each other", equal_surface_speeds},
    Case{"OpenDemImpact", "Self test of the open benchmark", open_dem_impact},
    Case{"ImpulseOfTheThesis", "Impulse of a rebound, chapter 3", impulse_of_the_thesis}};

}  // namespace

std::span<const Case> impact_cases() { return kCases; }

}  // namespace graintruth::sim::cases
