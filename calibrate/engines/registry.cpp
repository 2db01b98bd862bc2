#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibrate/engines/engine.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

#define KIND(name) const Engine& name();
#include "calibrate/engines/kinds.def"
#undef KIND

namespace {

using GetEngine = const Engine& (*)();

std::vector<GetEngine>& all() {
  static std::vector<GetEngine> known = {
#define KIND(name) &(name),
#include "calibrate/engines/kinds.def"
#undef KIND
  };
  return known;
}

}  // namespace

void make_known(const Engine& (*engine)()) { all().push_back(engine); }

const Engine& engine_named(std::string_view name) {
  for (const GetEngine engine : all()) {
    if (engine().name() == name) return engine();
  }
  throw datasets::InputError(fmt::format(
      "There is no engine '{}'; the engines are {}.", name, fmt::join(engine_names(), ", ")));
}

std::vector<std::string_view> engine_names() {
  std::vector<std::string_view> names;
  for (const GetEngine engine : all()) names.push_back(engine().name());
  return names;
}

std::string_view name_of(RunStatus status) {
  switch (status) {
    case RunStatus::completed:
      return "completed";
    case RunStatus::unstable:
      return "unstable";
    case RunStatus::timed_out:
      return "timed_out";
  }
  return "";
}

EngineRun run_with_retry(const Engine& engine,
                         const SimulationSpec& spec,
                         const EngineOptions& options) {
  EngineRun run = engine.run(spec, options);
  if (run.status != RunStatus::unstable) return run;
  SimulationSpec finer = spec;
  finer.time_step_fraction *= 0.5;
  for (datasets::ScenePhase& phase : finer.scene.phases) phase.time_step_fraction *= 0.5;
  EngineRun again = engine.run(finer, options);
  if (again.status != RunStatus::completed) return run;
  again.message =
      "unstable at the time step asked for (" + run.message + "), completed at half of it";
  again.seconds += run.seconds;
  return again;
}

}  // namespace graintruth::calibrate
