#include "datasets/experiment/joint_experiment.h"

#include <fmt/format.h>

#include <set>

#include "datasets/experiment/tuned_parameters.h"
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

JointPart read_part(TomlSection& section, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / section.text("file");
  if (!std::filesystem::is_regular_file(file))
    section.fail("file", fmt::format("names '{}', but there is no such file", file.string()));
  JointPart part{load_experiment(file)};
  if (const auto name = section.optional_text("name")) {
    if (name->empty() || name->find('/') != std::string::npos)
      section.fail("name", "must be a plain file name");
    part.experiment.name = *name;
  }
  part.weight = section.optional_quantity("weight", plain, positive).value_or(1.0);
  section.finish();
  return part;
}

// Of the first experiment that has what the parameter sets: every one has grains and walls, but not
// every one a wall of this name.
const Experiment* first_with(const std::vector<JointPart>& parts, const Parameter& parameter) {
  for (const JointPart& part : parts) {
    const Experiment& experiment = part.experiment;
    if (!parameter.kind->is_of_a_wall || has_wall(experiment.rig.scene, parameter.wall) ||
        experiment.material.stated(parameter.name))
      return &experiment;
  }
  return nullptr;
}

void require_same_bench(const TomlSection& section,
                        const std::vector<JointPart>& before,
                        const Experiment& other) {
  for (const auto& [name, bench] : other.material.bench) {
    const Experiment* first = first_with(before, parameter_named(name));
    if (first == nullptr) continue;
    const double here = bench.value;
    const double there = bench_value(*first, name).value;
    if (here == there) continue;
    section.fail("file",
                 fmt::format("gives a material.{} of {:.4g}, where {} has {:.4g}; experiments that "
                             "are calibrated together have the same grains and walls",
                             name,
                             here,
                             first->file.string(),
                             there));
  }
}

// The bench values of the first experiment, and those of walls that only others have.
Material joined_material(const std::vector<JointPart>& parts) {
  Material joined = parts.front().experiment.material;
  for (const JointPart& part : parts) {
    for (const auto& [name, bench] : part.experiment.material.bench) {
      if (parameter_named(name).kind->is_of_a_wall && !joined.stated(name))
        joined.bench.emplace_back(name, bench);
    }
  }
  return joined;
}

// Where films come from must be said on every page, so parts that say it are repeated.
std::string joined_notes(const std::string& own, const std::vector<JointPart>& parts) {
  std::string notes = own;
  for (const JointPart& part : parts) {
    const std::string& note = part.experiment.note;
    if (note.empty() || notes.find(note) != std::string::npos) continue;
    notes += notes.empty() ? note : " " + note;
  }
  return notes;
}

}  // namespace

bool is_joint(const std::filesystem::path& file) {
  TomlSection root = TomlFile(file).root();
  return root.has("experiment") && !root.has("particle");
}

JointExperiment load_joint_experiment(const std::filesystem::path& file) {
  TomlSection root = TomlFile(file).root();
  JointExperiment joint;
  const std::string title = root.text("title");
  const std::string note = root.optional_text("note").value_or("");

  // 1. The experiments
  std::set<std::string> names;
  for (TomlSection& section : root.sections("experiment")) {
    JointPart part = read_part(section, file.parent_path());
    require_same_bench(section, joint.parts, part.experiment);
    if (!names.insert(part.experiment.name).second) {
      section.fail(section.has("name") ? "name" : "file",
                   fmt::format("makes a second experiment called '{}'; give one of them a name",
                               part.experiment.name));
    }
    joint.parts.push_back(std::move(part));
  }
  if (joint.parts.size() < 2)
    root.fail("experiment", "is given once, but at least 2 experiments are calibrated together");

  // 2. What is sought in all of them
  joint.common = joint.parts.front().experiment;
  joint.common.file = file;
  joint.common.name = experiment_name(file);
  joint.common.title = title;
  joint.common.note = joined_notes(note, joint.parts);
  joint.common.material = joined_material(joint.parts);
  joint.common.tuned.clear();
  joint.common.time_step_rule = TimeStepRule::gate;
  joint.common.objective = ObjectiveForm::smooth;
  std::vector<const SceneData*> scenes;
  for (const JointPart& part : joint.parts) scenes.push_back(&part.experiment.rig.scene);
  read_tuned(root.section("tune"), scenes, joint.common);
  joint.common.execution = {};
  if (auto section = root.optional_section("execution"))
    joint.common.execution = read_execution(*section, file.parent_path());
  root.finish();
  for (JointPart& part : joint.parts) {
    part.experiment.part_of = title;
    part.experiment.tuned = joint.common.tuned;
    part.experiment.time_step_rule = joint.common.time_step_rule;
    part.experiment.objective = joint.common.objective;
  }
  return joint;
}

}  // namespace graintruth::datasets
