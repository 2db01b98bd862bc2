#include "datasets/experiment/experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "datasets/experiment/annotation.h"
#include "datasets/experiment/replicates.h"
#include "datasets/experiment/tuned_parameters.h"
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"
#include "datasets/rigs/rig_kind.h"
#include "datasets/scene/scene_particle.h"
#include "datasets/store/input_error.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

constexpr Range poisson_range{-1.0, 0.4999, false, "a Poisson ratio above -1 and below 0.5"};

BenchValue read_bench_value(TomlSection& section, const Parameter& parameter) {
  const ParameterKind& kind = *parameter.kind;
  return {section.quantity(parameter.name, kind.units, kind.range),
          section.optional_quantity(parameter.name + "_uncertainty", kind.units, positive)
              .value_or(0.0)};
}

bool states(TomlSection& section, const Parameter& parameter) {
  return section.optional_quantity(parameter.name, parameter.kind->units).has_value();
}

// Bench values that are stated; those that every experiment gives must be.
void read_bench_values(TomlSection& section, bool may_lack, Material& material) {
  for (const ParameterKind* kind : parameter_kinds()) {
    if (kind->stated_in != nullptr) continue;
    if (kind->is_of_a_wall) {
      for (const std::string& key : section.keys()) {
        const auto parameter = find_parameter(key);
        if (parameter && parameter->kind == kind && !key.ends_with("_uncertainty"))
          material.bench.emplace_back(key, read_bench_value(section, *parameter));
      }
      continue;
    }
    const Parameter parameter = parameter_named(kind->name);
    const bool must = kind->is_always_stated && !may_lack;
    if (must || states(section, parameter))
      material.bench.emplace_back(parameter.name, read_bench_value(section, parameter));
  }
}

Material read_material(TomlSection section) {
  Material material;
  material.elastic_modulus = section.quantity("elastic_modulus", pressure_units, positive);
  material.poisson_ratio = section.quantity("poisson_ratio", plain, poisson_range);
  read_bench_values(section, false, material);
  section.finish();
  return material;
}

// What the scene has of a parameter. Where walls differ, a parameter of all walls has what most of
// them have; those of single walls tell the others.
std::optional<double> scene_value(const ParameterKind& kind, const SceneData& scene) {
  if (const auto value = kind.value_in("", scene)) return value;
  for (const ParameterKind* of_a_wall : parameter_kinds()) {
    if (!of_a_wall->is_of_a_wall || of_a_wall->same_as != kind.name) continue;
    std::map<double, int> walls;
    for (const SceneWall& wall : scene.walls) {
      if (const auto value = of_a_wall->value_in(wall.name, scene)) ++walls[*value];
    }
    const auto most =
        std::max_element(walls.begin(), walls.end(), [](const auto& a, const auto& b) {
          return a.second < b.second;
        });
    if (most != walls.end()) return most->first;
  }
  return std::nullopt;
}

// Of a rig that brings its grains: what its scene says, where the file does not.
Material material_of(const SceneData& scene, std::optional<TomlSection> section) {
  Material material;
  if (!scene.particles.empty()) {
    const SceneMaterial& grains = scene.materials[scene.particles.front().material];
    material.elastic_modulus = grains.elastic_modulus;
    material.poisson_ratio = grains.poisson_ratio;
  }
  if (section) {
    read_bench_values(*section, true, material);
    section->finish();
  }
  std::vector<std::string> names = plain_parameter_names();
  for (const SceneWall& wall : scene.walls) {
    for (const ParameterKind* kind : parameter_kinds()) {
      if (kind->is_of_a_wall) names.push_back(fmt::format("{}{}", kind->name, wall.name));
    }
  }
  for (const std::string& name : names) {
    const Parameter parameter = parameter_named(name);
    const ParameterKind& kind = *parameter.kind;
    const auto value =
        kind.is_of_a_wall ? kind.value_in(parameter.wall, scene) : scene_value(kind, scene);
    if (!value || material.stated(name) || kind.stated_in != nullptr) continue;
    // What surfaces in general have says nothing of one wall
    if (!kind.same_as.empty() && scene_value(*parameter_named(kind.same_as).kind, scene) == value)
      continue;
    // Of one wall also none at all, where the others have some
    if (!kind.is_always_stated && !kind.is_of_a_wall && *value == kind.neutral) continue;
    material.bench.emplace_back(name, BenchValue{*value, 0.0});
  }
  return material;
}

std::vector<StartPlace> read_starts(TomlSection& root, int count) {
  std::vector<StartPlace> starts;
  for (TomlSection& start : root.sections("start")) {
    starts.push_back({start.quantity("x", length_units),
                      start.quantity("z", length_units),
                      start.optional_quantity("angle", angle_units).value_or(0.0)});
    start.finish();
  }
  if (!starts.empty() && static_cast<int>(starts.size()) != count) {
    root.fail("start",
              fmt::format("gives {} starting places for {} particles", starts.size(), count));
  }
  return starts;
}

// [measure]: what is compared, and when.
Measurement read_measurement(std::optional<TomlSection> section, const Rig& rig) {
  Measurement measurement;
  std::vector<std::string> names = rig.observables;
  if (section) {
    const auto interval = section->optional_quantity("frame_interval", time_units, positive);
    const auto frames = section->optional_whole_number("frames", 2, 100000);
    if (interval.has_value() != frames.has_value())
      section->fail(interval ? "frames" : "frame_interval_s", "is missing; give both, or none");
    measurement.frame_interval = interval.value_or(measurement.frame_interval);
    measurement.frames = frames.value_or(measurement.frames);
    const auto compared = section->optional_text("compare");
    const auto listed = section->optional_texts("observables");
    if (compared && listed) section->fail("compare", "says what 'observables' says already");
    if (compared && *compared != "particles" && *compared != "heap_height")
      section->fail("compare", "must be \"particles\" or \"heap_height\"");
    if (compared) names = {*compared == "particles" ? "tracks" : *compared};
    if (listed) {
      names = *listed;
      if (names.empty()) section->fail("observables", "is empty; name at least one");
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (std::count(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) > 0)
          section->fail("observables", fmt::format("names '{}' twice", names[i]));
      }
    }
  }
  for (const std::string& name : names) {
    RequestedObservable requested{.name = name};
    if (auto own = section ? section->optional_section(name) : std::nullopt) {
      requested.weight = own->optional_quantity("weight", plain, positive).value_or(1.0);
      requested.settings = std::make_shared<TomlSection>(*std::move(own));
    }
    measurement.observables.push_back(std::move(requested));
  }
  if (!section) return measurement;
  for (const std::string& key : section->keys()) {
    if (!section->is_table(key) || std::find(names.begin(), names.end(), key) != names.end())
      continue;
    section->fail(key,
                  fmt::format("describes an observable that is not compared; add \"{}\" to "
                              "measure.observables, or leave the table out",
                              key));
  }
  section->finish();
  return measurement;
}

}  // namespace

std::string_view name_of(ObjectiveForm form) {
  return form == ObjectiveForm::smooth ? "smooth" : "requested";
}

const BenchValue* Material::stated(std::string_view parameter) const {
  for (const auto& [name, value] : bench) {
    if (name == parameter) return &value;
  }
  return nullptr;
}

BenchValue bench_value(const Experiment& experiment, std::string_view parameter) {
  if (const BenchValue* stated = experiment.material.stated(parameter)) return *stated;
  const ParameterKind& kind = *parameter_named(parameter).kind;
  if (kind.stated_in != nullptr) return {kind.stated_in(experiment.material), 0.0};
  if (!kind.same_as.empty()) return bench_value(experiment, kind.same_as);
  return {kind.neutral, 0.0};
}

ParameterSet bench_parameters(const Experiment& experiment) {
  ParameterSet parameters;
  for (const auto& [name, bench] : experiment.material.bench) parameters.set(name, bench.value);
  for (const TunedParameter& tuned : experiment.tuned) {
    if (!parameters.has(tuned.name))
      parameters.set(tuned.name, bench_value(experiment, tuned.name).value);
  }
  return parameters;
}

namespace {

// Bench values of walls that are not there.
void require_walls(const TomlSection& section, const Experiment& experiment) {
  for (const auto& [name, bench] : experiment.material.bench) {
    const std::string wall = parameter_named(name).wall;
    if (wall.empty() || has_wall(experiment.rig.scene, wall)) continue;
    std::vector<std::string> walls;
    for (const SceneWall& one : experiment.rig.scene.walls) walls.push_back(one.name);
    section.fail(
        name,
        fmt::format(
            "is of a wall '{}', but the walls of the rig are {}", wall, fmt::join(walls, ", ")));
  }
}

}  // namespace

std::string experiment_name(const std::filesystem::path& file) {
  return file.stem() == "experiment" && file.has_parent_path()
             ? std::filesystem::absolute(file).parent_path().filename().string()
             : file.stem().string();
}

namespace {

Experiment read_experiment(const AnnotatedFile& annotated,
                           const std::filesystem::path& file,
                           Purpose purpose) {
  TomlSection root = annotated.file.root();
  if (root.has("experiment") && !root.has("particle")) {
    root.fail("experiment",
              "lists experiments that are calibrated together, which only 'calibrate' and 'check' "
              "take; give the file of one of them");
  }
  const std::filesystem::path folder = file.parent_path();
  Experiment experiment;
  experiment.file = file;
  experiment.annotation = annotated.annotation;
  experiment.name = experiment_name(file);
  // What a calibration cannot do without; of a film that is only tracked, what is there
  const bool only_tracked = purpose == Purpose::tracking;
  const auto is_read = [&](const char* key) { return !only_tracked || root.has(key); };
  experiment.title = is_read("title") ? root.text("title") : experiment.name;
  experiment.note = root.optional_text("note").value_or("");
  // 1. Rig and grains: one may bring the other
  std::optional<TomlSection> rig;
  int filled_count = 0;
  if (is_read("rig")) rig = root.section("rig");
  RigContext context{.folder = folder, .inputs = &experiment.inputs, .notes = &experiment.notes};
  if (rig && rig_kind_named(*rig).brings_grains) {
    if (root.has("particle"))
      root.fail("particle", "is not needed: the grains are those of the rig's scene");
    experiment.rig = read_rig(*rig, nullptr, context);
    experiment.particle = particle_of(experiment.rig.scene);
    experiment.material = material_of(experiment.rig.scene, root.optional_section("material"));
  } else {
    const bool rig_may_count = rig && rig_kind_named(*rig).pours_a_bed;
    experiment.particle =
        read_particle(root.section("particle"), purpose, rig_may_count, folder, experiment.inputs);
    check_density(root.section("particle"), experiment.particle, file, experiment.notes);
    if (is_read("material")) experiment.material = read_material(root.section("material"));
    context.particle = &experiment.particle;
    if (rig) {
      experiment.rig = read_rig(*rig, nullptr, context);
      TomlSection particle = root.section("particle");
      filled_count = experiment.rig.filled_count;
      if (experiment.rig.scene.is_planar) require_one_layer(particle, experiment.particle.model);
    }
  }
  experiment.starts = read_starts(root, experiment.particle.count);
  // 2. Replicates, each in its own state of the rig
  context.inputs = nullptr;
  context.notes = nullptr;
  experiment.replicates = read_replicates(root, folder, purpose, [&](TomlSection& replicate) {
    return rig ? read_rig(root.section("rig"), &replicate, context) : Rig{};
  });
  if (filled_count > 0) set_count(filled_count, experiment.particle);
  if (rig && root.has("material")) require_walls(root.section("material"), experiment);
  bool films = false;
  for (const Replicate& replicate : experiment.replicates) films |= !replicate.video.empty();
  // A camera is only needed by those who filmed.
  if (films || root.has("camera"))
    experiment.camera = read_camera(root.section("camera"), folder, films);
  for (Replicate& replicate : experiment.replicates)
    replicate.source.usual_frame_rate = experiment.camera.frame_rate;
  // 3. What is compared, and what is sought
  experiment.measurement = read_measurement(root.optional_section("measure"), experiment.rig);
  if (auto section = root.optional_section("tune"))
    read_tuned(*section, std::array{&std::as_const(experiment.rig.scene)}, experiment);
  if (auto section = root.optional_section("execution"))
    experiment.execution = read_execution(*section, folder);
  if (auto section = root.optional_section("simulation"))
    experiment.simulator = read_simulator(*section, folder);
  root.finish();
  return experiment;
}

}  // namespace

Experiment load_experiment(const std::filesystem::path& file, Purpose purpose) {
  return read_experiment(read_annotated(file), file, purpose);
}

Experiment load_experiment(const std::filesystem::path& file,
                           const std::filesystem::path& annotation,
                           Purpose purpose) {
  return read_experiment(read_annotated(file, annotation), file, purpose);
}

Experiment as_filmed(const Experiment& experiment, const Replicate& replicate) {
  Experiment filmed = experiment;
  filmed.camera.frame_rate = replicate.frame_rate.value_or(experiment.camera.frame_rate);
  if (replicate.noted_event_time) filmed.camera.noted_event_time = replicate.noted_event_time;
  filmed.rig = replicate.rig;
  return filmed;
}

std::map<std::string, double> read_parameter_table(const std::filesystem::path& file) {
  TomlSection root = TomlFile(file).root();
  std::map<std::string, double> values;
  std::vector<std::string> names = plain_parameter_names();
  for (const std::string& key : root.keys()) {
    if (const auto parameter = find_parameter(key); parameter && parameter->kind->is_of_a_wall)
      names.push_back(key);
  }
  for (const std::string& name : names) {
    const ParameterKind& kind = *parameter_named(name).kind;
    if (const auto value = root.optional_quantity(name, kind.units, kind.range))
      values[name] = *value;
  }
  root.finish();
  return values;
}

}  // namespace graintruth::datasets
