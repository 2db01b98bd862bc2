// The bodies of a running simulation: one array per quantity, planar or spatial. Velocities live at half steps (leapfrog).
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

// Orientations in space. The spin is kept in body axes, where the inertia is constant.
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

template <int D>
struct Bodies {
  using Spin = typename Motion<D>::Spin;

  // Constant
  double layer = 0.0;  // m; y of a planar scene
  std::vector<double> mass;
  std::vector<Spin> inertia;  // kg m2; planar: about y, spatial: principal
  std::vector<double> bounding_radius;
  std::vector<int> material;
  std::vector<int> first_sphere;  // of body i; one more entry than bodies
  std::vector<double> sphere_radius;
  std::vector<Vec<D>> sphere_in_body;

  // Motion
  std::vector<Vec<D>> position;
  std::vector<Vec<D>> velocity;  // half a step back
  std::vector<Spin> spin;        // half a step back, world axes
  std::vector<Vec<D>> acceleration;
  std::vector<Spin> angular_acceleration;  // planar only; spatial: in turns
  typename TurnsOf<D>::type turns;

  // Predicted at the present time, second order; what dashpots and observers see
  std::vector<Vec<D>> velocity_now;
  std::vector<Spin> spin_now;

  std::vector<Vec<D>> sphere_position;
  std::vector<Vec<D>> force;
  std::vector<Spin> torque;

  int count() const { return static_cast<int>(mass.size()); }
};

// Velocities of the scene are taken as those of the present time; accelerations start at zero.
template <int D>
Bodies<D> make_bodies(const Scene& scene);

// The element spheres of body i where they are now.
void place_spheres(Bodies<2>& bodies, int i);
void place_spheres(Bodies<3>& bodies, int i);

template <int D>
void write_state(const Bodies<D>& bodies, State& state);

}  // namespace graintruth::sim
