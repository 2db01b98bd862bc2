// The force of the grains on a wall of the rig, as a load cell behind it measures it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "calibrate/observables/curve_observable.h"
#include "datasets/store/input_error.h"
#include "datasets/store/toml_section.h"

namespace graintruth::calibrate {

namespace {

// [measure.wall_force] wall = "side", axis = "x"; the replicates' column is wall_force_n.
std::shared_ptr<const Observable> make(const datasets::Experiment& experiment,
                                       datasets::TomlSection* settings) {
  if (settings == nullptr) {
    throw datasets::InputError(
        fmt::format("{}: 'wall_force' is compared, but nothing says on which wall; write "
                    "[measure.wall_force] wall = \"...\", axis = \"x\", \"y\" or \"z\".",
                    experiment.file.string()));
  }
  const std::string wall = settings->text("wall"), axis = settings->text("axis");
  const auto& walls = experiment.rig.scene.walls;
  if (std::none_of(walls.begin(), walls.end(), [&](const auto& one) { return one.name == wall; })) {
    std::vector<std::string> names;
    for (const datasets::SceneWall& one : walls) names.push_back(one.name);
    settings->fail(
        "wall",
        fmt::format("is '{}', but the walls of the rig are {}", wall, fmt::join(names, ", ")));
  }
  if (axis != "x" && axis != "y" && axis != "z")
    settings->fail("axis", "must be \"x\", \"y\" or \"z\": the direction of the force");
  return std::make_shared<CurveObservable>(
      OwnCurve{.name = "wall_force",
               .column = settings->optional_text("column").value_or("wall_force_n"),
               .engine_curve = fmt::format("wall_force_{}_{}_n", wall, axis),
               .unit = "N",
               .title = fmt::format("Force on {}, along {}", wall, axis),
               .number = read_curve_number(*settings)});
}

}  // namespace

extern constinit const ObservableKind wall_force_kind{.name = "wall_force", .make = make};

}  // namespace graintruth::calibrate
