// The bodies of a running simulation: one array per quantity, planar or spatial. Velocities live at
// half steps (leapfrog).
#pragma once

#include <vector>

#include "sim/motion.h"
#include "sim/scene.h"
#include "sim/state.h"

namespace graintruth::sim {

// Orientations in the layer: unwrapped picture angle, and its cosine and sine for placing spheres.
struct PlanarTurns {
  std::vector<double> angle;
  std::vector<Vec2> direction;
};

// Orientations in space. The spin is kept in body axes, where the inertia is constant; that of a
// round body, whose inertia is the same about all axes, in world axes.
struct SpatialTurns {
  std::vector<Quat> world_from_body;
  std::vector<Vec3> spin_in_body;          // rad/s, half a step back
  std::vector<Vec3> acceleration_in_body;  // rad/s2, of the last step
};

template <int D>
struct TurnsOf;
template <>
struct TurnsOf<2> {
  using type = PlanarTurns;
};
template <>
struct TurnsOf<3> {
  using type = SpatialTurns;
};

// What the contact loop reads of a body, side by side: one cache line in the plane, two in space.
// `velocity` and `spin` are those half a step back (leapfrog); `..._now` are predicted at the
// present time, second order, and are what dashpots and observers see.
template <int D>
struct alignas(64) BodyMotion {
  Vec<D> position;
  Vec<D> velocity;
  Vec<D> velocity_now;
  typename Motion<D>::Spin spin;  // rad/s, world axes
  typename Motion<D>::Spin spin_now;
};

// Sum of the contacts on a body.
template <int D>
struct Load {
  typename Motion<D>::Vector force = Motion<D>::no_vector();     // N
  typename Motion<D>::Tangent torque = Motion<D>::no_tangent();  // N m; about the centre of mass
};

template <int D>
struct Bodies {
  using Spin = typename Motion<D>::Spin;

  // Constant
  double layer = 0.0;  // m; y of a planar scene
  std::vector<double> mass;
  std::vector<double> inverse_mass;
  std::vector<Spin> inertia;  // kg m2; planar: about y, spatial: principal
  std::vector<Spin> inverse_inertia;
  std::vector<char> is_round;  // 1 for equal principal moments of inertia
  std::vector<double> bounding_radius;
  std::vector<int> material;
  std::vector<int> first_sphere;  // of body i; one more entry than bodies
  std::vector<double> sphere_radius;
  std::vector<Vec<D>> sphere_in_body;

  std::vector<BodyMotion<D>> motion;
  std::vector<Vec<D>> acceleration;
  std::vector<Spin> angular_acceleration;  // planar only; spatial: in turns
  typename TurnsOf<D>::type turns;

  std::vector<Vec<D>> sphere_position;
  std::vector<Load<D>> load;

  int count() const { return static_cast<int>(mass.size()); }
};

// Velocities of the scene are taken as those of the present time; accelerations start at zero.
template <int D>
Bodies<D> make_bodies(const Scene& scene);

// The element spheres of body i where they are now (thesis 2.20).
inline void place_spheres(Bodies<2>& bodies, int i) {
  const Vec2 centre = bodies.motion[i].position;
  const Vec2 along = bodies.turns.direction[i];
  const Vec2 across(-along.y(), along.x());
  const Vec2* in_body = bodies.sphere_in_body.data();
  Vec2* placed = bodies.sphere_position.data();
  const int end = bodies.first_sphere[i + 1];
  for (int s = bodies.first_sphere[i]; s < end; ++s) {
    placed[s] = centre + in_body[s].x() * along + in_body[s].y() * across;
  }
}

inline void place_spheres(Bodies<3>& bodies, int i, const Mat3& world_from_body) {
  const Vec3 centre = bodies.motion[i].position;
  for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
    bodies.sphere_position[s] = centre + world_from_body * bodies.sphere_in_body[s];
  }
}
inline void place_spheres(Bodies<3>& bodies, int i) {
  const int first = bodies.first_sphere[i];
  if (bodies.first_sphere[i + 1] == first + 1 && bodies.sphere_in_body[first].isZero(0.0)) {
    bodies.sphere_position[first] = bodies.motion[i].position;
    return;
  }
  place_spheres(bodies, i, bodies.turns.world_from_body[i].toRotationMatrix());
}

template <int D>
void write_state(const Bodies<D>& bodies, State& state);

}  // namespace graintruth::sim
