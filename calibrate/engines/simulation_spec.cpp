#include "calibrate/engines/simulation_spec.h"

#include <map>

#include "datasets/parameters/parameter_archive.h"
#include "datasets/scene/scene_archive.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/trajectory_archive.h"

namespace graintruth::datasets {

template <class Archive>
void list_fields(Archive& archive, ForeignEngine& foreign) {
  auto& [command, command_hash, curves, ranks] = foreign;
  archive("command", command)("command_hash", command_hash)("curves", curves)("ranks", ranks);
}

}  // namespace graintruth::datasets

namespace graintruth::calibrate {

template <class Archive>
void list_fields(Archive& archive, FilmedStart& start) {
  auto& [poses, standard_deviation] = start;
  archive("poses", poses)("standard_deviation", standard_deviation);
}

template <class Archive>
void list_fields(Archive& archive, OutlinePlan& plan) {
  auto& [columns, eye, surface, from_z, to_z] = plan;
  archive("columns_m", columns)("eye_x_m", eye.x)("eye_z_m", eye.z);
  archive("eye_distance_m", eye.distance);
  datasets::list_if_any(archive, "surface", surface);
  archive("from_z_m", from_z)("to_z_m", to_z);
}

template <class Archive>
void list_fields(Archive& archive, RecordPlan& plan) {
  auto& [tracks, curves, outlines] = plan;
  archive("tracks", tracks)("curves", curves);
  datasets::list_surfaces(archive, outlines);
}

template <class Archive>
void list_fields(Archive& archive, SimulationSpec& spec) {
  auto& [engine,
         engine_version,
         parameters,
         time_step_fraction,
         seed,
         scene,
         start,
         record,
         foreign] = spec;
  archive("engine", engine)("engine_version", engine_version)("parameters", parameters);
  archive("time_step_fraction", time_step_fraction)("seed", seed)("scene", scene);
  archive("start", start)("record", record)("foreign", foreign);
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
  // 1. By what a person would call them; what has no name of its own belongs to the rig
  const std::map<std::string, std::string> names = {{"particles", "particle"},
                                                    {"materials", "material"},
                                                    {"surfaces", "material"},
                                                    {"law", "material"},
                                                    {"phases", "phases"},
                                                    {"event_phase", "phases"}};
  std::map<std::string, datasets::Json> parts;
  for (const auto& [key, value] : json["scene"].items()) {
    const auto name = names.find(key);
    parts[name == names.end() ? "rig" : name->second][key] = value;
  }
  parts["the program's numbers"] = {json["engine"], json["engine_version"]};
  if (json.contains("foreign")) parts["the program's numbers"].push_back(json["foreign"]);
  parts["starting poses"] = json["start"];
  parts["what is recorded"] = json["record"];
  // 2. Hashes
  SpecParts hashes;
  for (const auto& [name, part] : parts)
    hashes.emplace_back(name, datasets::content_hash(part.dump()));
  return hashes;
}

}  // namespace graintruth::calibrate
