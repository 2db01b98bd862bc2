// The listings of a scene's fields, for the archives of store/archive.h: what a simulation is told,
// and what its fingerprint is made of.
#pragma once

#include "datasets/scene/scene_file.h"
#include "datasets/store/archive.h"

namespace graintruth::datasets {

template <>
struct EnumWords<SizeSpread::Kind> {
  static constexpr std::array words = {"none", "uniform", "normal", "lognormal"};
};
template <>
struct EnumWords<SceneWall::Kind> {
  static constexpr std::array words = {"segment", "plane", "polygon", "disk", "cylinder", "mesh"};
};
template <>
struct EnumWords<SceneFill::Method> {
  static constexpr std::array words = {"lattice", "rain", "rows"};
};

template <class Archive>
void list_fields(Archive& archive, SceneMaterial& material) {
  auto& [name, is_rigid, elastic_modulus, poisson_ratio] = material;
  archive("name", name)("rigid", is_rigid)("elastic_modulus_pa", elastic_modulus);
  archive("poisson_ratio", poisson_ratio);
}

template <class Archive>
void list_fields(Archive& archive, SceneSurfaces& surfaces) {
  auto& [first, second, friction, restitution, static_friction, rolling_friction] = surfaces;
  archive("first", first)("second", second)("friction", friction)("restitution", restitution);
  archive("static_friction", static_friction)("rolling_friction", rolling_friction);
}

template <class Archive>
void list_fields(Archive& archive, SceneLaw& law) {
  auto& [normal_spring,
         tangential_spring,
         coulomb_limit,
         tension,
         damping_form,
         damping_sharing,
         linear_stiffness,
         tangential_stiffness,
         tangential_damping] = law;
  archive("normal_spring", normal_spring)("tangential_spring", tangential_spring);
  archive("coulomb_limit", coulomb_limit)("tension", tension)("damping_form", damping_form);
  archive("damping_sharing", damping_sharing)("linear_stiffness_n_per_m", linear_stiffness);
  archive("tangential_stiffness_n_per_m", tangential_stiffness);
  archive("tangential_damping", tangential_damping);
}

template <class Archive>
void list_fields(Archive& archive, SceneSphere& sphere) {
  auto& [centre, radius] = sphere;
  archive("centre_m", centre)("radius_m", radius);
}

template <class Archive>
void list_fields(Archive& archive, SceneProfile& profile) {
  auto& [points, ellipse, chords] = profile;
  archive("points_m", points)("ellipse_m", ellipse)("chords", chords);
}

template <class Archive>
void list_fields(Archive& archive, SceneChain& chain) {
  auto& [count, aspect_ratio, ball_radius] = chain;
  archive("count", count)("aspect_ratio", aspect_ratio)("ball_radius_m", ball_radius);
}

template <class Archive>
void list_fields(Archive& archive, SizeSpread& size) {
  auto& [kind, standard_deviation, classes] = size;
  archive("distribution", kind)("standard_deviation", standard_deviation)("classes", classes);
}

template <class Archive>
void list_fields(Archive& archive, SceneParticle& particle) {
  auto& [name, material, count, spheres, profile, chain, density, mass, inertia, size] = particle;
  archive("name", name)("material", material)("count", count)("spheres", spheres);
  archive("profile", profile)("chain", chain)("density_kg_per_m3", density)("mass_kg", mass);
  archive("inertia_kg_m2", inertia)("size", size);
}

template <class Archive>
void list_fields(Archive& archive, SceneMotion& motion) {
  auto& [velocity, angular_velocity, pivot, start, end] = motion;
  archive("velocity_m_per_s", velocity)("angular_velocity_rad_per_s", angular_velocity);
  archive("pivot_m", pivot)("start_s", start)("end_s", end);
}

template <class Archive>
void list_fields(Archive& archive, SceneWall& wall) {
  auto& [name, material, kind, points, normal, radius, motion, drag, opens_at, body] = wall;
  archive("name", name)("material", material)("shape", kind)("points_m", points);
  archive("normal", normal)("radius_m", radius)("motion", motion)("surface_motion", drag);
  archive("opens_s", opens_at)("body", body);
}

template <class Archive>
void list_fields(Archive& archive, SceneRoom& room) {
  auto& [from, to, radius] = room;
  archive("from_m", from)("to_m", to)("radius_m", radius);
}

template <class Archive>
void list_fields(Archive& archive, SceneFill& fill) {
  auto& [method,
         low,
         high,
         clearance,
         jitter,
         body_centred,
         within,
         random_orientation,
         angle,
         interval,
         speed,
         length,
         number] = fill;
  archive("method", method)("low_m", low)("high_m", high)("clearance_m", clearance);
  archive("jitter_m", jitter)("body_centred", body_centred)("within", within);
  archive("random_orientation", random_orientation)("angle_rad", angle)("interval_s", interval);
  archive("speed_m_per_s", speed)("length_m", length)("number", number);
}

template <class Archive>
void list_fields(Archive& archive, ScenePlace& place) {
  auto& [particle, position, angle, azimuth, velocity, angular_velocity] = place;
  archive("particle", particle)("position_m", position)("angle_rad", angle);
  archive("azimuth_rad", azimuth)("velocity_m_per_s", velocity);
  archive("angular_velocity_rad_per_s", angular_velocity);
}

template <class Archive>
void list_fields(Archive& archive, ScenePhase& phase) {
  auto& [name,
         duration,
         until_rest,
         output_interval,
         time_step_fraction,
         fastest_impact,
         global_damping,
         friction_between_particles,
         friction_with_walls,
         restitution,
         restitution_at_most,
         damping_ratio] = phase;
  archive("name", name)("duration_s", duration)("until_rest", until_rest);
  archive("output_interval_s", output_interval)("time_step_fraction", time_step_fraction);
  archive("fastest_impact_m_per_s", fastest_impact)("global_damping_per_s", global_damping);
  archive("friction_between_particles", friction_between_particles);
  archive("friction_with_walls", friction_with_walls)("restitution", restitution);
  archive("restitution_at_most", restitution_at_most)("damping_ratio", damping_ratio);
}

template <class Archive>
void list_fields(Archive& archive, ScenePeriod& period) {
  auto& [low, length] = period;
  archive("low_m", low)("length_m", length);
}

template <class Archive>
void list_fields(Archive& archive, SceneData& scene) {
  auto& [is_planar,
         gravity,
         period,
         materials,
         surfaces,
         law,
         particles,
         walls,
         fill,
         places,
         phases,
         event_phase,
         exit_height,
         leaves_below] = scene;
  archive("planar", is_planar)("gravity_m_per_s2", gravity)("period", period);
  archive("materials", materials);
  archive("surfaces", surfaces)("law", law)("particles", particles)("walls", walls);
  archive("fill", fill)("places", places)("phases", phases)("event_phase", event_phase);
  archive("exit_height_m", exit_height)("leaves_below_m", leaves_below);
}

}  // namespace graintruth::datasets
