// The bodies of a running simulation: one array per quantity, planar or spatial. Velocities live at
// half steps (leapfrog).
#pragma once

#include <vector>

#include "sim/columns.h"
#include "sim/scene.h"
#include "sim/state.h"

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

// Sum of the contacts on a body.
template <int D>
struct Load {
  typename Motion<D>::Vector force = Motion<D>::no_vector();     // N
  typename Motion<D>::Tangent torque = Motion<D>::no_tangent();  // N m; about the centre of mass
};

template <int D>
struct Bodies {
  using Spins = TangentColumn<D, BodyNumbers>;

  // Constant
  double layer = 0.0;  // m; y of a planar scene
  BodyNumbers mass;
  BodyNumbers inverse_mass;
  Spins inertia;  // kg m2; planar: about y, spatial: principal
  Spins inverse_inertia;
  BodyNumbers gyration;  // 0 for equal principal moments, whose gyroscopic term is zero; else 1
  BodyNumbers reach_squared;  // m2; largest distance of a surface point from the centre
  BodyNumbers bounding_radius;
  std::vector<char> is_centred_sphere;  // 1 for a single sphere about the centre of mass
  std::vector<int> material;
  std::vector<int> first_sphere;  // of body i; one more entry than bodies
  BodyNumbers sphere_radius;
  std::vector<typename Motion<D>::Vector> sphere_in_body;

  // Motion
  std::vector<BodyMotion<D>> motion;
  VectorColumn<D, BodyNumbers> acceleration;
  Spins angular_acceleration;  // spatial: in body axes
  typename TurnsOf<D>::type turns;

  std::vector<typename Motion<D>::Vector> sphere_position;
  std::vector<Load<D>> load;

  int count() const { return static_cast<int>(mass.size()); }
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
  const PlanarVector* in_body = bodies.sphere_in_body.data();
  PlanarVector* placed = bodies.sphere_position.data();
  const int end = bodies.first_sphere[i + 1];
  for (int s = bodies.first_sphere[i]; s < end; ++s) {
    placed[s] = centre + in_body[s].x * along + in_body[s].z * across;
  }
}

inline void place_spheres(Bodies<3>& bodies, int i) {
  const SpatialVector centre = bodies.motion[i].position;
  const int first = bodies.first_sphere[i];
  if (bodies.is_centred_sphere[i] != 0) {
    bodies.sphere_position[first] = centre;
    return;
  }
  const Rotation world_from_body = bodies.turns.world_from_body.at(i);
  const SpatialVector* in_body = bodies.sphere_in_body.data();
  SpatialVector* placed = bodies.sphere_position.data();
  const int end = bodies.first_sphere[i + 1];
  for (int s = first; s < end; ++s) {
    placed[s] = centre + turned_by(world_from_body, in_body[s]);
  }
}

template <int D>
void write_state(const Bodies<D>& bodies, State& state);

}  // namespace graintruth::sim
