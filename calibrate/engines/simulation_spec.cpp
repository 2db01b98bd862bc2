#include "calibrate/engines/simulation_spec.h"

#include "datasets/parameters/parameter_archive.h"
#include "datasets/scene_archive.h"
#include "datasets/store/fingerprint.h"
#include "datasets/trajectory_archive.h"

namespace graintruth::calibrate {

template <class Archive>
void list_fields(Archive& archive, FilmedStart& start) {
  auto& [poses, standard_deviation] = start;
  archive("poses", poses)("standard_deviation", standard_deviation);
}

template <class Archive>
void list_fields(Archive& archive, RecordPlan& plan) {
  auto& [tracks, curves] = plan;
  archive("tracks", tracks)("curves", curves);
}

template <class Archive>
void list_fields(Archive& archive, SimulationSpec& spec) {
  auto& [engine, engine_version, parameters, time_step_fraction, seed, scene, start, record] = spec;
  archive("engine", engine)("engine_version", engine_version)("parameters", parameters);
  archive("time_step_fraction", time_step_fraction)("seed", seed)("scene", scene);
  archive("start", start)("record", record);
}

std::string to_text(const SimulationSpec& spec) { return datasets::to_json(spec).dump(); }

SimulationSpec spec_from_text(const std::string& text) {
  const datasets::Json json = datasets::Json::parse(text, nullptr, false);
  if (json.is_discarded()) throw std::invalid_argument("is not valid JSON");
  return datasets::from_json<SimulationSpec>(json);
}

std::string fingerprint_of(const SimulationSpec& spec) {
  return datasets::content_hash(to_text(spec));
}

SpecParts parts_of(const SimulationSpec& spec) {
  const datasets::Json json = datasets::to_json(spec);
  const auto of = [](const datasets::Json& part) { return datasets::content_hash(part.dump()); };
  const datasets::Json& scene = json["scene"];
  return {{"the program's numbers", of({json["engine"], json["engine_version"]})},
          {"particle", of(scene["particles"])},
          {"material", of({scene["materials"], scene["law"]})},
          {"rig", of({scene["walls"], scene["gravity_m_per_s2"], scene["fill"], scene["places"]})},
          {"phases", of(scene["phases"])},
          {"starting poses", of(json["start"])}};
}

}  // namespace graintruth::calibrate
