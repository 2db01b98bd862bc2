// The bodies of a running simulation: one array per quantity, planar or spatial. Velocities live at
// half steps (leapfrog).
#pragma once

#include <array>
#include <vector>

#include "sim/engine/columns.h"
#include "sim/engine/periodic_cell.h"
#include "sim/engine/state.h"
#include "sim/scene.h"

namespace graintruth::sim {

using BodyNumbers = std::vector<double>;

// Orientations in the layer: unwrapped picture angle, and its cosine and sine for placing spheres.
struct PlanarTurns {
  BodyNumbers angle;
  VectorColumn<2, BodyNumbers> direction;
};

// Orientations in space. The spin is kept in body axes, where the inertia is constant.
struct SpatialTurns {
  RotationColumn<BodyNumbers> world_from_body;
  VectorColumn<3, BodyNumbers> spin_in_body;  // rad/s, half a step back
  // rad/s2, body axes; of the last step, from which the gyroscopic term is found. None while all
  // bodies are round.
  VectorColumn<3, BodyNumbers> last_angular_acceleration;
};

// `Orientations` alone tell how far a body has turned.
template <int D>
struct TurnsOf;
template <>
struct TurnsOf<2> {
  using type = PlanarTurns;
  using Orientations = VectorColumn<2, BodyNumbers>;
};
template <>
struct TurnsOf<3> {
  using type = SpatialTurns;
  using Orientations = RotationColumn<BodyNumbers>;
};

// What the contact loop reads of a body, side by side: one cache line in the plane, two in space.
// `velocity` and `spin` are those half a step back (leapfrog); `..._now` are predicted at the
// present time, second order, and are what dashpots and observers see.
template <int D>
struct alignas(64) BodyMotion {
  typename Motion<D>::Vector position;
  typename Motion<D>::Vector velocity;
  typename Motion<D>::Vector velocity_now;
  typename Motion<D>::Tangent spin;  // rad/s, world axes
  typename Motion<D>::Tangent spin_now;
};

// Columns of motions, and the numbers of a motion in their order.
template <int D, class Numbers>
struct MotionColumns {
  VectorColumn<D, Numbers> position, velocity, velocity_now;
  TangentColumn<D, Numbers> spin, spin_now;
};
template <class Numbers>
std::array<Rows, 8> columns_of(MotionColumns<2, Numbers>& motion) {
  return {motion.position.x.data(),
          motion.position.z.data(),
          motion.velocity.x.data(),
          motion.velocity.z.data(),
          motion.velocity_now.x.data(),
          motion.velocity_now.z.data(),
          motion.spin.value.data(),
          motion.spin_now.value.data()};
}
template <class Numbers>
std::array<Rows, 15> columns_of(MotionColumns<3, Numbers>& motion) {
  return {motion.position.x.data(),
          motion.position.y.data(),
          motion.position.z.data(),
          motion.velocity.x.data(),
          motion.velocity.y.data(),
          motion.velocity.z.data(),
          motion.velocity_now.x.data(),
          motion.velocity_now.y.data(),
          motion.velocity_now.z.data(),
          motion.spin.x.data(),
          motion.spin.y.data(),
          motion.spin.z.data(),
          motion.spin_now.x.data(),
          motion.spin_now.y.data(),
          motion.spin_now.z.data()};
}

// An element sphere where it is now; four numbers, so that one load brings it.
template <int D>
struct alignas(32) PlacedSphere {
  typename Motion<D>::Vector centre;  // m
  double radius = 0.0;                // m
};

// Sum of the contacts on a body. In the plane the last of its four numbers means nothing.
template <int D>
struct alignas(D == 2 ? 32 : 16) Load {
  typename Motion<D>::Vector force = Motion<D>::no_vector();     // N
  typename Motion<D>::Tangent torque = Motion<D>::no_tangent();  // N m; about the centre of mass
};

// Columns of loads, in the order of a load's numbers.
template <class Numbers>
std::array<Rows, 3> columns_of(VectorColumn<2, Numbers>& force, ScalarColumn<Numbers>& torque) {
  return {force.x.data(), force.z.data(), torque.value.data()};
}
template <class Numbers>
std::array<Rows, 6> columns_of(VectorColumn<3, Numbers>& force, VectorColumn<3, Numbers>& torque) {
  return {force.x.data(),
          force.y.data(),
          force.z.data(),
          torque.x.data(),
          torque.y.data(),
          torque.z.data()};
}

template <int D>
inline void add(const Load<D>& more, Load<D>& load) {
  load.force = load.force + more.force;
  load.torque = load.torque + more.torque;
}

// What bodies of one type of clump have in common.
template <int D>
struct BodyKind {
  using Tangent = typename Motion<D>::Tangent;
  double mass = 0.0;          // kg
  double inverse_mass = 0.0;  // 1/kg
  Tangent inertia = {};       // kg m2; planar: about y, spatial: principal
  Tangent inverse_inertia = {};
  double least_turn =
      0.0;  // 1/(kg m2); 1 over the largest principal moment, in the plane that about y
  double gyration = 0.0;  // 0 for equal principal moments, whose gyroscopic term is zero; else 1
  double bounding_radius = 0.0;  // m; largest distance of a surface point from the centre
  bool is_ball = false;          // a single sphere about the centre of mass
  int material = 0;
  std::vector<typename Motion<D>::Vector> spheres;  // m; centres in the body frame
};

template <int D>
struct Bodies {
  // Constant
  PeriodicCell<D> cell;
  double layer = 0.0;              // m; y of a planar scene
  bool are_alike = true;           // all of one mass and one material
  bool are_single_spheres = true;  // no two bodies can touch at two places
  bool are_balls = true;           // single spheres, each about its centre of mass
  std::vector<BodyKind<D>> kinds;
  std::vector<int> kind;          // of each body
  std::vector<int> first_sphere;  // of body i; one more entry than bodies
  std::vector<int> body_of_sphere;

  // Motion
  std::vector<BodyMotion<D>> motion;
  typename TurnsOf<D>::type turns;

  std::vector<PlacedSphere<D>> spheres;
  // Each step sums the loads anew; the accelerations that they give then take their place
  std::vector<Load<D>> load;
  std::vector<Load<D>>
      load_from_before;  // by contacts of earlier slabs; none when there is one slab

  int count() const { return static_cast<int>(kind.size()); }
  const BodyKind<D>& kind_of(int i) const { return kinds[kind[i]]; }
  // m/s2, and rad/s2 in body axes; of the last step
  typename Motion<D>::Vector& acceleration(int i) { return load[i].force; }
  typename Motion<D>::Tangent& angular_acceleration(int i) { return load[i].torque; }
  typename Motion<D>::Vector acceleration(int i) const { return load[i].force; }
  typename Motion<D>::Tangent angular_acceleration(int i) const { return load[i].torque; }
  int sphere_count() const { return static_cast<int>(spheres.size()); }
};

inline const VectorColumn<2, BodyNumbers>& orientations_of(const PlanarTurns& turns) {
  return turns.direction;
}
inline const RotationColumn<BodyNumbers>& orientations_of(const SpatialTurns& turns) {
  return turns.world_from_body;
}

// Velocities of the scene are taken as those of the present time; accelerations start at zero.
template <int D>
Bodies<D> make_bodies(const Scene& scene);

// The element spheres of body i where they are now (thesis 2.20).
inline void place_spheres(Bodies<2>& bodies, int i) {
  const PlanarVector centre = bodies.motion[i].position;
  const PlanarVector along = bodies.turns.direction.at(i);
  const PlanarVector across{-along.z, along.x};
  PlacedSphere<2>* placed = bodies.spheres.data() + bodies.first_sphere[i];
  for (const PlanarVector& in_body : bodies.kind_of(i).spheres) {
    (placed++)->centre = centre + in_body.x * along + in_body.z * across;
  }
}

inline void place_spheres(Bodies<3>& bodies, int i) {
  const SpatialVector centre = bodies.motion[i].position;
  PlacedSphere<3>* placed = bodies.spheres.data() + bodies.first_sphere[i];
  const BodyKind<3>& kind = bodies.kind_of(i);
  if (kind.is_ball) {
    placed->centre = centre;
    return;
  }
  const Rotation world_from_body = bodies.turns.world_from_body.at(i);
  for (const SpatialVector& in_body : kind.spheres) {
    (placed++)->centre = centre + turned_by(world_from_body, in_body);
  }
}

// Body i back into the cell, with its spheres. Returns by how much it was moved, m.
template <int D>
typename Motion<D>::Vector bring_into_cell(Bodies<D>& bodies, int i) {
  const auto shift = shift_into(bodies.cell, bodies.motion[i].position);
  if (dot(shift, shift) == 0.0) return shift;
  bodies.motion[i].position = bodies.motion[i].position + shift;
  place_spheres(bodies, i);
  return shift;
}

template <int D>
void write_state(const Bodies<D>& bodies, State& state);

}  // namespace graintruth::sim
