#include "sim/engine/relaxation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/engine/neighbours.h"
#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

// Every correction aims at this share of the allowed overlap, so that the sweeps end after a finite
// number.
constexpr double kAim = 0.5;

class Relaxation {
 public:
  Relaxation(Scene& scene, double time) : scene_(scene), cell_(periodic_cell<3>(scene.period)) {
    move_walls(scene.walls, time, walls_);
    for (const Body& body : scene.bodies)
      bounding_.push_back(scene.types[body.type].bounding_radius);
    position_.resize(scene.bodies.size());
  }

  // Visits every overlap deeper than `allowed` once and corrects it to `aim`; returns the deepest
  // that was seen. With `correct` false nothing is moved.
  double sweep(double allowed, double aim, bool correct) {
    deepest_ = 0.0;
    for (std::size_t i = 0; i < position_.size(); ++i) position_[i] = scene_.bodies[i].position;
    find_near_pairs<3>(position_, bounding_, margin_of(allowed), cells_, pairs_, cell_);
    for (const IndexPair& pair : pairs_)
      part_bodies(pair.first, pair.second, allowed, aim, correct);
    for (int i = 0; i < static_cast<int>(scene_.bodies.size()); ++i) {
      for (int w = 0; w < static_cast<int>(walls_.size()); ++w)
        leave_wall(i, w, allowed, aim, correct);
    }
    return deepest_;
  }

 private:
  // Bodies move a little within a sweep; pairs that come to touch by that are found in the next
  // one.
  static double margin_of(double allowed) { return allowed; }

  const Clump& type_of(int i) const { return scene_.types[scene_.bodies[i].type]; }

  Vec3 sphere_at(int i, const ElementSphere& sphere) const {
    return scene_.bodies[i].position + scene_.bodies[i].orientation * sphere.centre;
  }

  // How readily body i gives way at `lever` along n: 1/m + (l x n) I^-1 (l x n)
  double yielding(int i, const Vec3& lever, const Vec3& n) const {
    const Vec3 turn = scene_.bodies[i].orientation.conjugate() * lever.cross(n);
    return 1.0 / type_of(i).mass + turn.dot(turn.cwiseQuotient(type_of(i).inertia));
  }

  void push(int i, const Vec3& lever, const Vec3& impulse) {
    Body& body = scene_.bodies[i];
    const Vec3 in_body = body.orientation.conjugate() * lever.cross(impulse);
    const Vec3 turn = body.orientation * in_body.cwiseQuotient(type_of(i).inertia);
    body.position += impulse / type_of(i).mass;
    if (scene_.planar) {
      body.picture_angle += picture_spin_of(turn);
      body.orientation = orientation_from_picture_angle(body.picture_angle);
      body.position.y() = layer();
    } else if (turn.norm() > 0.0) {
      body.orientation =
          (turn_about(turn.normalized(), turn.norm()) * body.orientation).normalized();
    }
  }

  double layer() const { return position_.front().y(); }

  void part_bodies(int i, int j, double allowed, double aim, bool correct) {
    for (const ElementSphere& a : type_of(i).spheres) {
      for (const ElementSphere& b : type_of(j).spheres) {
        const Vec3 at_a = sphere_at(i, a), at_b = sphere_at(j, b);
        const Vec3 straight = at_b - at_a;
        const Vec3 apart = straight + to_eigen(shift_to_nearest(cell_, plain(straight)));
        const double distance = apart.norm();
        const double overlap = a.radius + b.radius - distance;
        deepest_ = std::max(deepest_, overlap);
        if (!correct || overlap <= allowed) continue;
        const Vec3 n = distance > 0.0 ? Vec3(apart / distance) : Vec3(Vec3::UnitX());
        const Vec3 lever_i = at_a + a.radius * n - scene_.bodies[i].position;
        const Vec3 lever_j = at_b - b.radius * n - scene_.bodies[j].position;
        const Vec3 impulse =
            n * ((overlap - aim) / (yielding(i, lever_i, n) + yielding(j, lever_j, n)));
        push(i, lever_i, -impulse);
        push(j, lever_j, impulse);
      }
    }
  }

  void leave_wall(int i, int w, double allowed, double aim, bool correct) {
    const double bounding = type_of(i).bounding_radius;
    if (look_at(walls_[w], scene_.bodies[i].position).distance > bounding) return;
    for (const ElementSphere& sphere : type_of(i).spheres) {
      const Vec3 centre = sphere_at(i, sphere);
      const WallView view = look_at(walls_[w], centre);
      const double overlap = sphere.radius - view.distance;
      deepest_ = std::max(deepest_, overlap);
      if (!correct || overlap <= allowed) continue;
      const Vec3 lever = sphere.radius * view.direction + (centre - scene_.bodies[i].position);
      push(i, lever, view.direction * (-(overlap - aim) / yielding(i, lever, view.direction)));
    }
  }

  Scene& scene_;
  PeriodicCell<3> cell_;
  std::vector<Wall> walls_;
  std::vector<double> bounding_;
  std::vector<Vec3> position_;
  CellList<3> cells_;
  std::vector<IndexPair> pairs_;
  double deepest_ = 0.0;
};

// Overlap under the weight of one body on its stiffest contact: (m g / k)^(2/3), k = 4/3 E*
// sqrt(R*)   (thesis 1.1)
double static_overlap(const Scene& scene) {
  double smallest = 0.0;
  for (const Body& body : scene.bodies) {
    const Clump& type = scene.types[body.type];
    double radius = 0.0;
    for (const ElementSphere& sphere : type.spheres) radius = std::max(radius, sphere.radius);
    // The stiffest partner there can be is a rigid wall
    const double modulus =
        mix(scene.materials[type.material], rigid_material(), Surfaces{}, Tension::allowed, 0.0)
            .normal_modulus;
    const double k = 4.0 / 3.0 * modulus * std::sqrt(radius);
    const double gravity = scene.gravity.norm() > 0.0 ? scene.gravity.norm() : 9.81;
    const double overlap = exact_pow(type.mass * gravity / k, 2.0 / 3.0);
    if (smallest == 0.0 || overlap < smallest) smallest = overlap;
  }
  return smallest;
}

}  // namespace

RelaxationSummary relax_overlaps(Scene& scene, const RelaxationOptions& options) {
  check(scene);
  RelaxationSummary summary;
  if (scene.bodies.empty()) {
    summary.converged = true;
    return summary;
  }
  const std::vector<Body> before = scene.bodies;
  const double allowed =
      options.allowed_overlap > 0.0 ? options.allowed_overlap : static_overlap(scene);

  // 1. Sweeps
  Relaxation relaxation(scene, options.time);
  summary.overlap_before = relaxation.sweep(allowed, kAim * allowed, false);
  summary.overlap_after = summary.overlap_before;
  while (summary.overlap_after > allowed && summary.sweeps < options.largest_sweep_count) {
    summary.overlap_after = relaxation.sweep(allowed, kAim * allowed, true);
    ++summary.sweeps;
  }
  summary.overlap_after = relaxation.sweep(allowed, kAim * allowed, false);
  summary.converged = summary.overlap_after <= allowed;

  // 2. What it took
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double move = (scene.bodies[i].position - before[i].position).norm();
    const Quat turned = scene.bodies[i].orientation * before[i].orientation.conjugate();
    const double turn = 2.0 * steady_atan2(turned.vec().norm(), std::abs(turned.w()));
    if (summary.worst_body < 0 || move > summary.largest_move) {
      summary.largest_move = move;
      summary.worst_body = static_cast<int>(i);
    }
    summary.largest_turn = std::max(summary.largest_turn, turn);
  }
  return summary;
}

double deepest_overlap(const Scene& scene, double time) {
  if (scene.bodies.empty()) return 0.0;
  Scene copy = scene;
  return Relaxation(copy, time).sweep(0.0, 0.0, false);
}

}  // namespace graintruth::sim
