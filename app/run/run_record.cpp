#include "app/run/run_record.h"

#include <fmt/format.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "calibrate/engines/scene_build.h"
#include "calibrate/problem.h"
#include "datasets/experiment/tracking_spec.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

Json bench_json(const datasets::BenchValue& bench) {
  return {{"value", bench.value}, {"standard_uncertainty", bench.standard_uncertainty}};
}

Json rig_json(const datasets::Rig& rig) {
  Json walls = Json::array();
  for (const datasets::Wall& wall : rig.walls) {
    walls.push_back({{"name", wall.name},
                     {"from_x_m", wall.from_x},
                     {"from_z_m", wall.from_z},
                     {"to_x_m", wall.to_x},
                     {"to_z_m", wall.to_z}});
  }
  Json json = {{"walls", walls},
               {"front_back_gap_m", rig.front_back_gap},
               {"gravity_m_per_s2", rig.gravity}};
  if (const auto& face = rig.moving_face) {
    json["piston"] = {{"face_z_m", face->face_z},
                      {"left_x_m", face->left_x},
                      {"right_x_m", face->right_x},
                      {"half_width_m", 0.5 * (face->right_x - face->left_x)},
                      {"velocity_z_m_per_s", face->velocity_z}};
  }
  return json;
}

// As before scales of other kinds came: units in the names of what every camera has.
Json camera_json(const datasets::Camera& camera) {
  Json json = Json::parse(datasets::json_text(camera));
  Json fiducials = Json::array();
  for (const datasets::Fiducial& fiducial : camera.fiducials)
    fiducials.push_back(
        {{"x_m", fiducial.x}, {"z_m", fiducial.z}, {"diameter_m", fiducial.diameter}});
  json["fiducials"] = fiducials;
  json["frame_rate_hz"] = camera.frame_rate;
  json.erase("frame_rate");
  return json;
}

// What is compared, of what, in which conditions.
void add_comparison(const datasets::Experiment& experiment, Json& json) {
  json["rig"] = experiment.rig.kind;
  Json observables = Json::array();
  for (const datasets::RequestedObservable& requested : experiment.measurement.observables)
    observables.push_back({{"name", requested.name}, {"weight", requested.weight}});
  json["measure"]["observables"] = observables;
  Json conditions = Json::array();
  for (const calibrate::Condition& condition : calibrate::conditions_of(experiment)) {
    Json settings = Json::object();
    for (const auto& [name, value, unit] : condition.settings)
      settings[fmt::format("{}_{}", name, unit)] = value;
    Json replicates = Json::array();
    for (const std::size_t r : condition.replicates)
      replicates.push_back(experiment.replicates[r].name);
    conditions.push_back(
        {{"settings", settings}, {"replicates", replicates}, {"held_out", condition.held_out}});
  }
  json["conditions"] = conditions;
}

Json configuration_json(const datasets::Experiment& experiment) {
  Json spheres = Json::array();
  for (const sim::ElementSphere& sphere : calibrate::spheres_of(experiment.particle.model)) {
    Json entry = {{"offset_m", sphere.centre.x()}, {"radius_m", sphere.radius}};
    // Of grains whose spheres do not lie on one axis
    if (sphere.centre.y() != 0.0 || sphere.centre.z() != 0.0) {
      entry["y_m"] = sphere.centre.y();
      entry["z_m"] = sphere.centre.z();
    }
    spheres.push_back(std::move(entry));
  }
  Json particle = {{"count", experiment.particle.count},
                   {"mass_kg", experiment.particle.mass},
                   {"spheres", spheres}};
  if (const auto& inertia = experiment.particle.model.inertia)
    particle["inertia_kg_m2"] = {inertia->x(), inertia->y(), inertia->z()};
  Json tuned = Json::object();
  for (const datasets::TunedParameter& parameter : experiment.tuned) {
    tuned[parameter.name] = {{"lower", parameter.lower}, {"upper", parameter.upper}};
    if (const auto& prior = parameter.prior) tuned[parameter.name]["prior"] = bench_json(*prior);
  }
  Json replicates = Json::array();
  for (const datasets::Replicate& replicate : experiment.replicates) {
    replicates.push_back(
        {{"name", replicate.name}, {"file", replicate.file().filename().string()}});
  }
  Json material = {{"elastic_modulus_pa", experiment.material.elastic_modulus},
                   {"poisson_ratio", experiment.material.poisson_ratio}};
  for (const auto& [name, bench] : experiment.material.bench) material[name] = bench_json(bench);
  return {{"title", experiment.title},
          {"note", experiment.note},
          {"particle", particle},
          {"material", material},
          {"camera", camera_json(experiment.camera)},
          {"measure",
           {{"frame_interval_s", experiment.measurement.frame_interval},
            {"frames", experiment.measurement.frames}}},
          {"tune", tuned},
          {"replicates", replicates}};
}

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

void write_run_record(const datasets::RunFolder& folder,
                      const CommonOptions& options,
                      const datasets::Experiment& experiment,
                      const RunRecord& record) {
  Json configuration = configuration_json(experiment);
  const datasets::Simulator& simulator = experiment.simulator;
  if (const calibrate::Engine& engine = calibrate::engine_named(simulator.engine);
      record.compares && engine.is_another_program()) {
    configuration["simulation"] = {{"engine", simulator.engine},
                                   {"version", engine.version()},
                                   {"command", simulator.foreign.command},
                                   {"ranks", simulator.foreign.ranks}};
  }
  if (record.compares) add_comparison(experiment, configuration);
  Json stages = Json::array();
  for (const calibrate::StageTime& stage : record.stages) {
    stages.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  }
  const Json json = {{"version", GRAINTRUTH_VERSION},
                     {"verb", record.verb},
                     {"command", options.command_line},
                     {"started_at", record.started_at},
                     {"seed", options.seed},
                     {"jobs", record.jobs},
                     {"options", record.options},
                     {"simulations_run", record.simulations_run},
                     {"configuration", configuration},
                     {"rig", rig_json(experiment.rig)},
                     {"input_hashes", record.input_hashes},
                     {"stages", stages}};
  datasets::write_whole(folder.run(), json.dump(2) + "\n");
}

}  // namespace graintruth::app
