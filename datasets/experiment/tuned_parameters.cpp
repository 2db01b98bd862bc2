#include "datasets/experiment/tuned_parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

// prior = "bench", or the mean and its uncertainty.
std::optional<BenchValue> read_prior(TomlSection& tuned,
                                     const Parameter& parameter,
                                     const Experiment& experiment) {
  if (!tuned.has("prior")) return std::nullopt;
  const ParameterKind& kind = *parameter.kind;
  if (tuned.keys().size() == 1) {
    tuned.fail("prior",
               "is given to a parameter without bounds, which stays at its bench value; write "
               "{lower = ..., upper = ..., prior = ...} to tune it");
  }
  if (tuned.is_table("prior")) {
    TomlSection stated = tuned.section("prior");
    const BenchValue prior{stated.quantity("mean", kind.units, kind.range),
                           stated.quantity("uncertainty", kind.units, positive)};
    stated.finish();
    return prior;
  }
  if (!tuned.is_text("prior") || tuned.text("prior") != "bench")
    tuned.fail("prior", "must be \"bench\" or {mean = ..., uncertainty = ...}");
  const BenchValue bench = bench_value(experiment, parameter.name);
  if (!(bench.standard_uncertainty > 0.0)) {
    tuned.fail("prior",
               fmt::format("is \"bench\", but the bench value has no uncertainty; give "
                           "'material.{}_uncertainty' (one standard deviation, above 0), or write "
                           "prior = {{mean = ..., uncertainty = ...}}",
                           parameter.name));
  }
  return bench;
}

// A prior that the bounds contradict is a mistake in one of them.
void check_prior(const TomlSection& tuned, const TunedParameter& parameter) {
  constexpr double far = 2.0;  // standard uncertainties
  const auto& prior = parameter.prior;
  if (!prior) return;
  const double reach = far * prior->standard_uncertainty;
  if (prior->value + reach >= parameter.lower && prior->value - reach <= parameter.upper) return;
  tuned.fail("prior",
             fmt::format("says {:.4g} with an uncertainty of {:.4g}, far outside the bounds {:.4g} "
                         "to {:.4g}; widen the bounds, or correct the prior",
                         prior->value,
                         prior->standard_uncertainty,
                         parameter.lower,
                         parameter.upper));
}

}  // namespace

namespace {

TunedParameter read_bounds(TomlSection bounds,
                           const Parameter& parameter,
                           const Experiment& experiment) {
  const ParameterKind& kind = *parameter.kind;
  const auto prior = read_prior(bounds, parameter, experiment);
  // An empty table asks for the usual bounds
  const bool is_usual = bounds.keys().empty();
  const TunedParameter tuned{
      parameter.name,
      is_usual ? kind.usual_lower : bounds.quantity("lower", kind.units, kind.range),
      is_usual ? kind.usual_upper : bounds.quantity("upper", kind.units, kind.range),
      prior};
  if (!(tuned.lower < tuned.upper)) bounds.fail("upper", "must be above lower");
  check_prior(bounds, tuned);
  bounds.finish();
  return tuned;
}

}  // namespace

void read_tuned(TomlSection section,
                std::span<const SceneData* const> scenes,
                Experiment& experiment) {
  std::vector<std::string> names = plain_parameter_names();
  for (const std::string& key : section.keys()) {
    const auto parameter = find_parameter(key);
    if (!parameter || !parameter->kind->is_of_a_wall) continue;
    const bool is_there = std::any_of(scenes.begin(), scenes.end(), [&](const SceneData* scene) {
      return has_wall(*scene, parameter->wall);
    });
    if (!is_there) {
      std::vector<std::string> walls;
      for (const SceneData* scene : scenes) {
        for (const SceneWall& wall : scene->walls) {
          if (std::find(walls.begin(), walls.end(), wall.name) == walls.end())
            walls.push_back(wall.name);
        }
      }
      section.fail(key,
                   fmt::format("is no parameter, as no rig has a wall '{}'; the walls are {}",
                               parameter->wall,
                               fmt::join(walls, ", ")));
    }
    names.push_back(key);
  }
  for (const std::string& name : names) {
    if (auto bounds = section.optional_section(name))
      experiment.tuned.push_back(read_bounds(*bounds, parameter_named(name), experiment));
  }
  const std::string rule = section.optional_text("time_step").value_or("gate");
  if (rule == "joint") {
    experiment.time_step_rule = TimeStepRule::joint;
  } else if (rule != "gate") {
    section.fail("time_step", "must be \"gate\" or \"joint\"");
  }
  const std::string objective = section.optional_text("objective").value_or("smooth");
  if (objective == name_of(ObjectiveForm::requested)) {
    experiment.objective = ObjectiveForm::requested;
  } else if (objective != name_of(ObjectiveForm::smooth)) {
    section.fail("objective", "must be \"smooth\" or \"requested\"");
  }
  section.finish();
}

}  // namespace graintruth::datasets
