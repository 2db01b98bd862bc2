#include "datasets/tuned_parameters.h"

#include <fmt/format.h>

namespace graintruth::datasets {

namespace {

constexpr Range friction_range{0.0, 5.0, true, "a friction from 0 to 5"};
constexpr Range restitution_range{0.0, 1.0, false, "a restitution above 0 and at most 1"};
// prior = "bench", or the mean and its uncertainty.
std::optional<BenchValue> read_prior(TomlSection& tuned,
                                     const std::string& name,
                                     const Material& material) {
  if (!tuned.has("prior")) return std::nullopt;
  if (!tuned.has("lower") && !tuned.has("upper")) {
    tuned.fail("prior",
               "is given to a parameter without bounds, which stays at its bench value; write "
               "{lower = ..., upper = ..., prior = ...} to tune it");
  }
  if (tuned.is_table("prior")) {
    TomlSection stated = tuned.section("prior");
    const BenchValue prior{stated.quantity("mean", plain, range_of(name)),
                           stated.quantity("uncertainty", plain, positive)};
    stated.finish();
    return prior;
  }
  if (!tuned.is_text("prior") || tuned.text("prior") != "bench")
    tuned.fail("prior", "must be \"bench\" or {mean = ..., uncertainty = ...}");
  const BenchValue& bench = bench_value(material, name);
  if (!(bench.standard_uncertainty > 0.0)) {
    tuned.fail("prior",
               fmt::format("is \"bench\", but the bench value has no uncertainty; give "
                           "'material.{}_uncertainty' (one standard deviation, above 0), or write "
                           "prior = {{mean = ..., uncertainty = ...}}",
                           name));
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

const Range& range_of(const std::string& parameter) {
  return parameter == "restitution" ? restitution_range : friction_range;
}

void read_tuned(TomlSection section, Experiment& experiment) {
  for (const char* name : parameter_names) {
    auto bounds = section.optional_section(name);
    if (!bounds) continue;
    const auto prior = read_prior(*bounds, name, experiment.material);
    const TunedParameter parameter{name,
                                   bounds->quantity("lower", plain, range_of(name)),
                                   bounds->quantity("upper", plain, range_of(name)),
                                   prior};
    if (!(parameter.lower < parameter.upper)) bounds->fail("upper", "must be above lower");
    check_prior(*bounds, parameter);
    bounds->finish();
    experiment.tuned.push_back(parameter);
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
