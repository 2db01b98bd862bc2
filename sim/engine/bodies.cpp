#include "sim/engine/bodies.h"

#include <algorithm>

namespace graintruth::sim {
namespace {

void start_turn(const Body& body, Bodies<2>& bodies) {
  bodies.turns.angle.push_back(body.picture_angle);
  const Vec2 axis = into_plane(body.orientation * Vec3::UnitX());
  bodies.turns.direction.push_back(plain(Vec2(axis.normalized())));
  bodies.motion.back().spin = picture_spin_of(body.angular_velocity);
}

void start_turn(const Body& body, Bodies<3>& bodies) {
  const Rotation world_from_body = plain(body.orientation);
  const SpatialVector spin = plain(body.angular_velocity);
  bodies.turns.world_from_body.push_back(world_from_body);
  bodies.turns.spin_in_body.push_back(turned_back(world_from_body, spin));
  bodies.motion.back().spin = spin;
}

template <int D>
BodyKind<D> kind_of(const Clump& type) {
  BodyKind<D> kind{.mass = type.mass,
                   .inverse_mass = 1.0 / type.mass,
                   .bounding_radius = type.bounding_radius,
                   .material = type.material};
  if constexpr (D == 2) {
    kind.inertia = type.inertia.y();
    kind.inverse_inertia = 1.0 / type.inertia.y();
    kind.least_turn = kind.inverse_inertia;
  } else {
    kind.inertia = plain(type.inertia);
    kind.inverse_inertia = plain(Vec3(type.inertia.cwiseInverse()));
    kind.least_turn = 1.0 / type.inertia.maxCoeff();
  }
  const bool is_round =
      type.inertia.x() == type.inertia.y() && type.inertia.y() == type.inertia.z();
  kind.gyration = is_round ? 0.0 : 1.0;
  kind.is_ball = type.spheres.size() == 1 && type.spheres.front().centre.isZero(0.0);
  for (const ElementSphere& sphere : type.spheres) {
    kind.spheres.push_back(plain(to_motion<D>(sphere.centre)));
  }
  return kind;
}

}  // namespace

template <int D>
Bodies<D> make_bodies(const Scene& scene) {
  Bodies<D> bodies;
  bodies.cell = periodic_cell<D>(scene.period);
  if (!scene.bodies.empty()) bodies.layer = scene.bodies.front().position.y();
  // Kinds that no body is of stay empty
  bodies.kinds.resize(scene.types.size());
  for (const Body& body : scene.bodies) {
    if (!bodies.kinds[body.type].spheres.empty()) continue;
    bodies.kinds[body.type] = kind_of<D>(scene.types[body.type]);
  }
  const bool some_gyrate = std::any_of(
      bodies.kinds.begin(), bodies.kinds.end(), [](const auto& k) { return k.gyration != 0.0; });
  // Vectors that grow leave holes of their size in memory
  const std::size_t count = scene.bodies.size();
  std::size_t sphere_count = 0;
  for (const Body& body : scene.bodies) sphere_count += scene.types[body.type].spheres.size();
  bodies.kind.reserve(count);
  bodies.motion.reserve(count);
  bodies.first_sphere.reserve(count + 1);
  bodies.body_of_sphere.reserve(sphere_count);
  bodies.spheres.reserve(sphere_count);
  bodies.first_sphere.push_back(0);
  for (const Body& body : scene.bodies) {
    const Clump& type = scene.types[body.type];
    bodies.kind.push_back(body.type);
    for (const ElementSphere& sphere : type.spheres) {
      bodies.spheres.push_back({Motion<D>::no_vector(), sphere.radius});
      bodies.body_of_sphere.push_back(bodies.count() - 1);
    }
    bodies.first_sphere.push_back(bodies.sphere_count());
    const BodyKind<D>&kind = bodies.kinds[body.type], &first = bodies.kind_of(0);
    bodies.are_alike =
        bodies.are_alike && kind.mass == first.mass && kind.material == first.material;
    bodies.are_balls = bodies.are_balls && kind.is_ball;
    bodies.are_single_spheres = bodies.are_single_spheres && kind.spheres.size() == 1;
    const auto velocity = plain(to_motion<D>(body.velocity));
    bodies.motion.push_back({plain(to_motion<D>(body.position)),
                             velocity,
                             velocity,
                             Motion<D>::no_tangent(),
                             Motion<D>::no_tangent()});
    start_turn(body, bodies);
    if constexpr (D == 3) {
      auto& last = bodies.turns.last_angular_acceleration;
      if (some_gyrate) last.push_back(Motion<D>::no_tangent());
    }
    bodies.motion.back().spin_now = bodies.motion.back().spin;
  }
  bodies.load.resize(count);
  for (int i = 0; i < bodies.count(); ++i) {
    place_spheres(bodies, i);
    bring_into_cell(bodies, i);
  }
  return bodies;
}

template <int D>
void write_state(const Bodies<D>& bodies, State& state) {
  const int count = bodies.count();
  state.position.resize(count);
  state.orientation.resize(count);
  state.velocity.resize(count);
  state.angular_velocity.resize(count);
  state.picture_angle.resize(D == 2 ? count : 0);
  for (int i = 0; i < count; ++i) {
    state.position[i] = to_space(to_eigen(bodies.motion[i].position), bodies.layer);
    state.velocity[i] = to_space(to_eigen(bodies.motion[i].velocity_now));
    if constexpr (D == 2) {
      state.picture_angle[i] = bodies.turns.angle[i];
      state.orientation[i] = orientation_from_picture_angle(bodies.turns.angle[i]);
      state.angular_velocity[i] = angular_velocity_from_picture_spin(bodies.motion[i].spin_now);
    } else {
      state.orientation[i] = to_eigen(bodies.turns.world_from_body.at(i));
      state.angular_velocity[i] = to_eigen(bodies.motion[i].spin_now);
    }
  }
}

template Bodies<2> make_bodies<2>(const Scene&);
template Bodies<3> make_bodies<3>(const Scene&);
template void write_state<2>(const Bodies<2>&, State&);
template void write_state<3>(const Bodies<3>&, State&);

}  // namespace graintruth::sim
