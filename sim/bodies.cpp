#include "sim/bodies.h"

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

}  // namespace

template <int D>
Bodies<D> make_bodies(const Scene& scene) {
  Bodies<D> bodies;
  if (!scene.bodies.empty()) bodies.layer = scene.bodies.front().position.y();
  bodies.first_sphere.push_back(0);
  for (const Body& body : scene.bodies) {
    const Clump& type = scene.types[body.type];
    bodies.mass.push_back(type.mass);
    bodies.inverse_mass.push_back(1.0 / type.mass);
    if constexpr (D == 2) {
      bodies.inertia.push_back(type.inertia.y());
      bodies.inverse_inertia.push_back(1.0 / type.inertia.y());
    } else {
      bodies.inertia.push_back(plain(type.inertia));
      bodies.inverse_inertia.push_back(plain(Vec3(type.inertia.cwiseInverse())));
    }
    const bool is_round =
        type.inertia.x() == type.inertia.y() && type.inertia.y() == type.inertia.z();
    bodies.is_centred_sphere.push_back(type.spheres.size() == 1 &&
                                       type.spheres.front().centre.isZero(0.0));
    bodies.gyration.push_back(is_round ? 0.0 : 1.0);
    bodies.reach_squared.push_back(type.bounding_radius * type.bounding_radius);
    bodies.bounding_radius.push_back(type.bounding_radius);
    bodies.material.push_back(type.material);
    for (const ElementSphere& sphere : type.spheres) {
      bodies.spheres.push_back({Motion<D>::no_vector(), sphere.radius});
      bodies.body_of_sphere.push_back(bodies.count() - 1);
      bodies.sphere_in_body.push_back(plain(to_motion<D>(sphere.centre)));
    }
    bodies.first_sphere.push_back(bodies.sphere_count());
    bodies.are_alike = bodies.are_alike && bodies.mass.back() == bodies.mass.front() &&
                       bodies.material.back() == bodies.material.front();
    bodies.are_balls = bodies.are_balls && bodies.is_centred_sphere.back() != 0;
    bodies.are_single_spheres = bodies.are_single_spheres && type.spheres.size() == 1;
    const auto velocity = plain(to_motion<D>(body.velocity));
    bodies.motion.push_back({plain(to_motion<D>(body.position)),
                             velocity,
                             velocity,
                             Motion<D>::no_tangent(),
                             Motion<D>::no_tangent()});
    start_turn(body, bodies);
    bodies.acceleration.push_back(Motion<D>::no_vector());
    bodies.angular_acceleration.push_back(Motion<D>::no_tangent());
    bodies.motion.back().spin_now = bodies.motion.back().spin;
  }
  const std::size_t count = scene.bodies.size();
  bodies.load.resize(count);
  for (int i = 0; i < bodies.count(); ++i) place_spheres(bodies, i);
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
