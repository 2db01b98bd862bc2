#include "app/scenes/scene_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/scenes/wall_patches.h"
#include "datasets/scene/particle_files.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"
#include "datasets/store/trajectories.h"

namespace graintruth::app {

namespace {

using datasets::number_text;
using Json = nlohmann::ordered_json;

double time_of(const calibrate::SceneRun& run, const calibrate::SceneFrame& frame) {
  return frame.state.time - run.event_time;
}

void write_spatial_tracks(const std::filesystem::path& path, const calibrate::SceneRun& run) {
  std::string text =
      "frame,time_s,particle,x_m,y_m,z_m,quaternion_w,quaternion_x,quaternion_y,quaternion_z,"
      "velocity_x_m_per_s,velocity_y_m_per_s,velocity_z_m_per_s\n";
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const sim::State& state = run.frames[f].state;
    const std::string time = number_text(time_of(run, run.frames[f]));
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      const sim::Vec3& x = state.position[i];
      const sim::Vec3& v = state.velocity[i];
      const sim::Quat& q = state.orientation[i];
      fmt::format_to(std::back_inserter(text), "{},{},{}", f, time, i + 1);
      for (const double number :
           {x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z()}) {
        fmt::format_to(std::back_inserter(text), ",{}", number);
      }
      text += '\n';
    }
  }
  datasets::write_whole(path, text);
}

// What came in is what is there: kinetic + gravity + elastic + losses - wall work, less its value
// at the event.
double balance(const sim::Energy& energy) {
  return energy.total() + energy.damping_loss + energy.friction_loss - energy.wall_work;
}

std::size_t event_frame(const calibrate::SceneRun& run) {
  std::size_t frame = 0;
  while (frame + 1 < run.frames.size() && time_of(run, run.frames[frame]) < 0.0) ++frame;
  return frame;
}

void write_energy(const std::filesystem::path& path, const calibrate::SceneRun& run) {
  datasets::Table table({"time_s",
                         "kinetic_j",
                         "gravity_j",
                         "elastic_j",
                         "damping_loss_j",
                         "friction_loss_j",
                         "wall_work_j",
                         "balance_j"});
  const double start = balance(run.frames[event_frame(run)].energy);
  for (const calibrate::SceneFrame& frame : run.frames) {
    const sim::Energy& e = frame.energy;
    table.add({number_text(time_of(run, frame)),
               number_text(e.kinetic),
               number_text(e.gravity),
               number_text(e.elastic),
               number_text(e.damping_loss),
               number_text(e.friction_loss),
               number_text(e.wall_work),
               number_text(balance(e) - start)});
  }
  datasets::write_csv(path, table);
}

void write_bed(const std::filesystem::path& path, const calibrate::SceneRun& run) {
  datasets::Table table({"time_s",
                         "particles",
                         "contacts",
                         "coordination",
                         "mean_normal_force_n",
                         "largest_normal_force_n",
                         "peak_normal_force_n",
                         "sliding_share",
                         "discharged",
                         "discharged_mass_kg"});
  for (const calibrate::SceneFrame& frame : run.frames) {
    const calibrate::BedState& bed = frame.bed;
    table.add({number_text(time_of(run, frame)),
               std::to_string(frame.state.position.size()),
               std::to_string(bed.contacts),
               number_text(bed.coordination),
               number_text(bed.mean_force),
               number_text(bed.largest_force),
               number_text(bed.peak_force),
               number_text(bed.sliding_share),
               std::to_string(bed.discharged),
               number_text(bed.discharged_mass)});
  }
  datasets::write_csv(path, table);
}

void write_wall_forces(const std::filesystem::path& path,
                       const datasets::SceneFile& file,
                       const calibrate::SceneRun& run) {
  datasets::Table table(
      {"time_s", "wall", "force_x_n", "force_y_n", "force_z_n", "peak_contact_force_n"});
  for (const calibrate::SceneFrame& frame : run.frames) {
    for (std::size_t w = 0; w < file.walls.size(); ++w) {
      const sim::Vec3& force = frame.wall_force[w];
      table.add({number_text(time_of(run, frame)),
                 file.walls[w].name,
                 number_text(force.x()),
                 number_text(force.y()),
                 number_text(force.z()),
                 number_text(frame.wall_peak[w])});
    }
  }
  datasets::write_csv(path, table);
}

void write_wall_strips(const std::filesystem::path& path,
                       const datasets::SceneFile& file,
                       const calibrate::SceneRun& run) {
  datasets::Table table({"time_s", "wall", "from_z_m", "to_z_m", "normal_force_n"});
  const sim::Strips& strips = run.strips;
  for (const calibrate::SceneFrame& frame : run.frames) {
    for (std::size_t w = 0; w < frame.strip_force.size(); ++w) {
      for (int i = 0; i < strips.count; ++i) {
        table.add({number_text(time_of(run, frame)),
                   file.walls[w].name,
                   number_text(strips.low + i * strips.height()),
                   number_text(strips.low + (i + 1) * strips.height()),
                   number_text(frame.strip_force[w][static_cast<std::size_t>(i)])});
      }
    }
  }
  datasets::write_csv(path, table);
}

void write_contacts(const std::filesystem::path& path, const calibrate::SceneRun& run) {
  datasets::Table table({"first",
                         "second",
                         "with_wall",
                         "overlap_m",
                         "normal_x",
                         "normal_y",
                         "normal_z",
                         "normal_force_n",
                         "tangential_force_n",
                         "slides"});
  for (const sim::ContactReport& contact : run.contacts) {
    table.add({std::to_string(contact.first + 1),
               std::to_string(contact.second + 1),
               contact.with_wall ? "1" : "0",
               number_text(contact.overlap),
               number_text(contact.normal.x()),
               number_text(contact.normal.y()),
               number_text(contact.normal.z()),
               number_text(contact.normal_force),
               number_text(contact.tangential_force.norm()),
               contact.slides ? "1" : "0"});
  }
  datasets::write_csv(path, table);
}

datasets::SphereCloud cloud_of(const calibrate::SceneRun& run, const calibrate::SceneFrame& frame) {
  datasets::SphereCloud cloud;
  const sim::State& state = frame.state;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const int type = run.scene.bodies[i].type;
    for (const sim::ElementSphere& sphere : run.scene.types[type].spheres) {
      const sim::Vec3 lever = state.orientation[i] * sphere.centre;
      cloud.centre.push_back(state.position[i] + lever);
      cloud.radius.push_back(sphere.radius);
      cloud.velocity.push_back(state.velocity[i] + state.angular_velocity[i].cross(lever));
      cloud.particle.push_back(static_cast<int>(i) + 1);
      cloud.type.push_back(type + 1);
    }
  }
  return cloud;
}

const char* text_of(sim::RunStatus status) {
  switch (status) {
    case sim::RunStatus::completed:
      return "completed";
    case sim::RunStatus::unstable:
      return "unstable";
    case sim::RunStatus::timed_out:
      return "stopped";
  }
  return "";
}

Json vector_json(const sim::Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json motion_json(const datasets::SceneMotion& motion) {
  Json json = {{"velocity_m_per_s", vector_json(motion.velocity)},
               {"angular_velocity_rad_per_s", vector_json(motion.angular_velocity)},
               {"pivot_m", vector_json(motion.pivot)},
               {"start_s", motion.start}};
  if (std::isfinite(motion.end)) json["end_s"] = motion.end;
  return json;
}

bool is_none(const datasets::SceneMotion& motion) {
  return motion.velocity.isZero(0.0) && motion.angular_velocity.isZero(0.0);
}

Json walls_json(const datasets::SceneFile& file) {
  constexpr const char* kinds[] = {"segment", "plane", "polygon", "disk", "cylinder", "mesh"};
  Json walls = Json::array();
  for (const datasets::SceneWall& wall : file.walls) {
    Json json = {{"name", wall.name},
                 {"material", file.materials[wall.material].name},
                 {"shape", kinds[static_cast<int>(wall.kind)]}};
    if (wall.kind == datasets::SceneWall::Kind::mesh) {
      json["facets"] = wall.points.size() / 3;
    } else {
      json["points_m"] = Json::array();
      for (const sim::Vec3& point : wall.points) json["points_m"].push_back(vector_json(point));
    }
    if (wall.radius > 0.0) json["radius_m"] = wall.radius;
    if (!is_none(wall.motion)) json["motion"] = motion_json(wall.motion);
    if (!is_none(wall.drag)) json["surface"] = motion_json(wall.drag);
    if (std::isfinite(wall.opens_at)) json["opens_s"] = wall.opens_at;
    walls.push_back(json);
  }
  return walls;
}

}  // namespace

datasets::Trajectories planar_tracks(const calibrate::SceneRun& run) {
  datasets::Trajectories tracks = datasets::make_trajectories(
      run.frames.size(), static_cast<int>(run.scene.bodies.size()), false);
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const sim::State& state = run.frames[f].state;
    tracks.time[f] = time_of(run, run.frames[f]);
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      tracks.poses[tracks.index(f, i)] = {
          state.position[i].x(), state.position[i].z(), state.picture_angle[i]};
    }
  }
  return tracks;
}

void write_scene_tables(const datasets::RunFolder& folder,
                        const datasets::SceneFile& file,
                        const calibrate::SceneRun& run) {
  if (!run.frames.empty()) {
    if (file.is_planar) {
      datasets::write_tracks(folder.tracks("simulation"), planar_tracks(run));
    } else {
      write_spatial_tracks(folder.tracks("simulation"), run);
    }
    write_energy(folder.table("energy"), run);
    write_bed(folder.table("bed"), run);
    write_wall_forces(folder.table("wall_forces"), file, run);
    write_wall_strips(folder.table("wall_strips"), file, run);
  }
  write_contacts(folder.table("contacts"), run);
}

void write_paraview(const datasets::RunFolder& folder, const calibrate::SceneRun& run) {
  const std::filesystem::path root = folder.root / "paraview";
  std::error_code error;
  std::filesystem::create_directories(root, error);
  if (error) {
    throw datasets::InputError(
        fmt::format("{}: cannot be made ({}).", root.string(), error.message()));
  }
  std::vector<std::pair<double, std::string>> spheres, walls;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const calibrate::SceneFrame& frame = run.frames[f];
    const datasets::SphereCloud cloud = cloud_of(run, frame);
    spheres.emplace_back(time_of(run, frame), fmt::format("spheres_{:05}.vtp", f));
    datasets::write_whole(root / spheres.back().second, datasets::vtp_of_spheres(cloud));
    if (!frame.walls.empty()) {
      const sim::Box box = picture_box(frame.walls, cloud.centre);
      std::vector<Patch> patches;
      std::vector<int> owner;
      for (std::size_t w = 0; w < frame.walls.size(); ++w) {
        for (Patch& patch : patches_of(frame.walls[w], box)) {
          patches.push_back(std::move(patch));
          owner.push_back(static_cast<int>(w) + 1);
        }
      }
      walls.emplace_back(time_of(run, frame), fmt::format("walls_{:05}.vtp", f));
      datasets::write_whole(root / walls.back().second, datasets::vtp_of_patches(patches, owner));
    }
  }
  datasets::write_whole(root / "spheres.pvd", datasets::pvd_of(spheres));
  datasets::write_whole(root / "walls.pvd", datasets::pvd_of(walls));
}

void write_ovito(const datasets::RunFolder& folder, const calibrate::SceneRun& run) {
  std::string text;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    text += datasets::lammps_snapshot(cloud_of(run, run.frames[f]), static_cast<long>(f));
  }
  datasets::write_whole(folder.root / "dump.lammpstrj", text);
}

Json scene_result(const datasets::SceneFile& file, const calibrate::SceneRun& run) {
  Json json;
  json["status"] = text_of(run.status);
  json["message"] = run.message;
  json["scene"] = file.name;
  json["title"] = file.title;
  json["particles"] = run.scene.bodies.size();
  double mass = 0.0;
  for (const sim::Body& body : run.scene.bodies) mass += run.scene.types[body.type].mass;
  json["mass_kg"] = mass;
  json["frames"] = run.frames.size();
  json["phases"] = Json::array();
  for (const calibrate::PhaseRecord& phase : run.phases) {
    json["phases"].push_back({{"name", phase.name},
                              {"start_s", phase.start - run.event_time},
                              {"end_s", phase.end - run.event_time},
                              {"steps", phase.steps},
                              {"time_step_s", phase.time_step},
                              {"came_to_rest", phase.came_to_rest}});
  }
  if (!run.frames.empty()) {
    const calibrate::SceneFrame& last = run.frames.back();
    json["time_s"] = time_of(run, last);
    json["coordination"] = last.bed.coordination;
    json["contacts"] = last.bed.contacts;
    json["largest_normal_force_n"] = last.bed.largest_force;
    if (file.exit_height) {
      json["discharged"] = {{"particles", last.bed.discharged},
                            {"mass_kg", last.bed.discharged_mass}};
    }
    json["energy"] = {
        {"kinetic_j", last.energy.kinetic},
        {"gravity_j", last.energy.gravity},
        {"elastic_j", last.energy.elastic},
        {"damping_loss_j", last.energy.damping_loss},
        {"friction_loss_j", last.energy.friction_loss},
        {"wall_work_j", last.energy.wall_work},
        {"balance_j", balance(last.energy) - balance(run.frames[event_frame(run)].energy)}};
    json["wall_force_n"] = Json::object();
    for (std::size_t w = 0; w < file.walls.size(); ++w) {
      json["wall_force_n"][file.walls[w].name] = vector_json(last.wall_force[w]);
    }
  }
  json["particle_kinds"] = Json::array();
  for (std::size_t p = 0; p < file.particles.size(); ++p) {
    const calibrate::ParticleKind& kind = run.kinds[p];
    const sim::Clump& clump = run.scene.types[kind.types[kind.types.size() / 2]];
    json["particle_kinds"].push_back(
        {{"name", file.particles[p].name},
         {"spheres", clump.spheres.size()},
         {"mass_kg", clump.mass},
         {"volume_m3", clump.volume},
         {"inertia_kg_m2", vector_json(clump.inertia)},
         {"size_classes", kind.types.size()},
         {"sphere_density", kind.roughness.sphere_density},
         {"contact_normal_error_deg", kind.roughness.contact_normal * 180.0 / std::numbers::pi},
         {"pseudo_friction_bound", kind.roughness.pseudo_friction},
         {"profile_protrusion_m", kind.protrusion}});
  }
  json["warnings"] = run.warnings;
  return json;
}

Json scene_configuration(const datasets::SceneFile& file) {
  Json json = {{"title", file.title},
               {"dimensions", file.is_planar ? 2 : 3},
               {"gravity_m_per_s2", vector_json(file.gravity)}};
  json["materials"] = Json::array();
  for (const datasets::SceneMaterial& material : file.materials) {
    Json entry = {{"name", material.name}, {"rigid", material.is_rigid}};
    if (!material.is_rigid) {
      entry["elastic_modulus_pa"] = material.elastic_modulus;
      entry["poisson_ratio"] = material.poisson_ratio;
    }
    json["materials"].push_back(entry);
  }
  json["surfaces"] = Json::array();
  for (const datasets::SceneSurfaces& surfaces : file.surfaces) {
    json["surfaces"].push_back({{"first", file.materials[surfaces.first].name},
                                {"second", file.materials[surfaces.second].name},
                                {"friction", surfaces.friction},
                                {"restitution", surfaces.restitution},
                                {"static_friction", surfaces.static_friction},
                                {"rolling_friction", surfaces.rolling_friction}});
  }
  const datasets::SceneLaw& law = file.law;
  json["law"] = {{"normal_spring", law.normal_spring},
                 {"tangential_spring", law.tangential_spring},
                 {"coulomb_limit", law.coulomb_limit},
                 {"tension", law.tension},
                 {"damping_form", law.damping_form},
                 {"damping_sharing", law.damping_sharing},
                 {"linear_stiffness_n_per_m", law.linear_stiffness},
                 {"tangential_stiffness_n_per_m", law.tangential_stiffness},
                 {"tangential_damping", law.tangential_damping}};
  json["particles"] = Json::array();
  for (const datasets::SceneParticle& particle : file.particles) {
    json["particles"].push_back({{"name", particle.name}, {"count", particle.count}});
  }
  json["walls"] = walls_json(file);
  json["phases"] = Json::array();
  for (const datasets::ScenePhase& phase : file.phases) {
    Json entry = {{"name", phase.name},
                  {"duration_s", phase.duration},
                  {"until_rest", phase.until_rest},
                  {"output_interval_s", phase.output_interval},
                  {"time_step_fraction", phase.time_step_fraction},
                  {"global_damping_per_s", phase.global_damping}};
    if (phase.friction_between_particles)
      entry["friction_between_particles"] = *phase.friction_between_particles;
    if (phase.friction_with_walls) entry["friction_with_walls"] = *phase.friction_with_walls;
    if (phase.restitution) entry["restitution"] = *phase.restitution;
    if (phase.damping_ratio) entry["damping_ratio"] = *phase.damping_ratio;
    json["phases"].push_back(entry);
  }
  return json;
}

}  // namespace graintruth::app
