#include "tests/sim/cases/invariance.h"

#include <array>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim::cases {
namespace {

Scene relaxed_rig() {
  Scene scene = scenes::micro_rig(0.2, 0.7);
  relax_overlaps(scene);
  return scene;
}

State run(const Scene& scene) {
  Simulation simulation(scene);
  simulation.run_until(kInvarianceTime);
  return simulation.state();
}

// With the same number of steps, whatever the units of time.
State run_in_steps(const Scene& scene, double unit_of_time, double speed = 0.1) {
  Simulation simulation(scene, {.time_step = {.impact_speed = speed}});
  simulation.run_until(unit_of_time * kInvarianceTime, {.interval = unit_of_time * 1e-5});
  return simulation.state();
}

// `expected` gives the place at which body i of `a` should be found as body `index(i)` of b.
template <class Place, class Angle>
Apart apart(const State& a, const State& b, const Place& place, const Angle& angle) {
  Worst places, angles;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    places.see((place(a.position[i]) - b.position[i]).norm());
    angles.see(angle(a.picture_angle[i]) - b.picture_angle[i]);
  }
  return {places.value, angles.value};
}

const auto kSamePlace = [](const Vec3& place) { return place; };
const auto kSameAngle = [](double angle) { return angle; };

}  // namespace

Apart apart_in_space() {
  Scene scene = relaxed_rig();
  const State planar = run(scene);
  scene.planar = false;
  const State spatial = run(scene);
  Worst places, angles;
  for (std::size_t i = 0; i < planar.position.size(); ++i) {
    places.see((planar.position[i] - spatial.position[i]).norm());
    angles.see(planar.orientation[i].angularDistance(spatial.orientation[i]));
  }
  return {places.value, angles.value};
}

Apart apart_turned(double angle) {
  const Eigen::Rotation2Dd turn(angle);
  const auto turned = [&](const Vec3& v) {
    const Vec2 in_picture = turn * Vec2(v.x(), v.z());
    return Vec3(in_picture.x(), v.y(), in_picture.y());
  };
  const Scene scene = relaxed_rig();
  Scene other = scene;
  other.gravity = turned(scene.gravity);
  for (Wall& wall : other.walls) {
    wall.from = turn * wall.from;
    wall.to = turn * wall.to;
    wall.motion.velocity = turned(wall.motion.velocity);
  }
  for (Body& body : other.bodies) {
    body.position = turned(body.position);
    body.picture_angle += angle;
    body.orientation = orientation_from_picture_angle(body.picture_angle);
  }
  return apart(run(scene), run(other), turned, [angle](double a) { return a + angle; });
}

Apart apart_mirrored() {
  const auto mirrored = [](const Vec3& v) { return Vec3(-v.x(), v.y(), v.z()); };
  const Scene scene = relaxed_rig();
  Scene other = scene;
  for (Wall& wall : other.walls) {
    wall.from.x() = -wall.from.x();
    wall.to.x() = -wall.to.x();
  }
  for (Body& body : other.bodies) {
    body.position = mirrored(body.position);
    body.picture_angle = -body.picture_angle;
    body.orientation = orientation_from_picture_angle(body.picture_angle);
  }
  return apart(run(scene), run(other), mirrored, [](double angle) { return -angle; });
}

Apart apart_renumbered(std::span<const int> order) {
  const Scene scene = relaxed_rig();
  Scene other = scene;
  for (std::size_t i = 0; i < order.size(); ++i) other.bodies[i] = scene.bodies[order[i]];
  std::reverse(other.walls.begin(), other.walls.end());
  const State a = run(scene);
  State b = run(other);
  const State shuffled = b;
  for (std::size_t i = 0; i < order.size(); ++i) {
    b.position[order[i]] = shuffled.position[i];
    b.picture_angle[order[i]] = shuffled.picture_angle[i];
  }
  return apart(a, b, kSamePlace, kSameAngle);
}

// Froude and Cauchy numbers are both kept: v ~ 1, g ~ v^2/L, E ~ rho v^2.
Apart apart_doubled() {
  Scene scene = relaxed_rig();
  for (Wall& wall : scene.walls) wall.motion.velocity.setZero();
  Scene large = scene;
  large.gravity *= 0.5;
  large.types[0] =
      make_clump(chain_of_spheres(2, 2.0 * 0.022225, 2.0 * 0.02783), {.mass = 8.0 * 0.142});
  for (Wall& wall : large.walls) {
    wall.from *= 2.0;
    wall.to *= 2.0;
  }
  for (Body& body : large.bodies) body.position *= 2.0;
  return apart(
      run_in_steps(scene, 1.0),
      run_in_steps(large, 2.0),
      [](const Vec3& place) { return Vec3(2.0 * place); },
      kSameAngle);
}

// Pa is 10 g/(cm s2).
Apart apart_in_cm_and_g() {
  const Scene scene = relaxed_rig();
  Scene other = scene;
  other.gravity *= 100.0;
  for (Material& material : other.materials) material.youngs_modulus *= 10.0;
  other.types[0] = make_clump(chain_of_spheres(2, 2.2225, 2.783), {.mass = 142.0});
  for (Wall& wall : other.walls) {
    wall.from *= 100.0;
    wall.to *= 100.0;
    wall.motion.velocity *= 100.0;
  }
  for (Body& body : other.bodies) body.position *= 100.0;
  Apart in_cm = apart(
      run_in_steps(scene, 1.0),
      run_in_steps(other, 1.0, 10.0),
      [](const Vec3& place) { return Vec3(100.0 * place); },
      kSameAngle);
  in_cm.place /= 100.0;
  return in_cm;
}

std::vector<Check> invariance_checks() {
  std::vector<Check> checks;
  const auto add = [&](const std::string& what, const Apart& apart) {
    const std::string source = "validation plan 3; round-off through some twenty contacts";
    checks.push_back(within(what + ": places, m", source, kClosePlaces, apart.place));
    checks.push_back(within(what + ": angles, rad", source, kCloseAngles, apart.angle));
  };
  Apart turned;
  for (const double angle : {0.3, 1.0, -2.0, 3.0}) {
    const Apart one = apart_turned(angle);
    turned = {std::max(turned.place, one.place), std::max(turned.angle, one.angle)};
  }
  add("micro rig turned by four angles", turned);
  add("mirrored", apart_mirrored());
  constexpr std::array kShuffled = {3, 7, 0, 9, 4, 1, 8, 2, 6, 5};
  add("bodies and walls renumbered", apart_renumbered(kShuffled));
  add("lengths doubled, gravity halved", apart_doubled());
  add("in centimetres and grams", apart_in_cm_and_g());
  add("in space instead of the layer", apart_in_space());
  return checks;
}

}  // namespace graintruth::sim::cases
