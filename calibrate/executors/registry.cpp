#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibrate/executors/executor.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

#define KIND(name) extern const ExecutorKind name;
#include "calibrate/executors/kinds.def"
#undef KIND

namespace {

std::vector<const ExecutorKind*>& all() {
  static std::vector<const ExecutorKind*> known = {
#define KIND(name) &(name),
#include "calibrate/executors/kinds.def"
#undef KIND
  };
  return known;
}

}  // namespace

void make_known(const ExecutorKind& kind) { all().push_back(&kind); }

std::unique_ptr<Executor> make_executor(std::string_view name, const ExecutorSetup& setup) {
  std::vector<std::string_view> names;
  for (const ExecutorKind* kind : all()) {
    if (kind->name == name) return kind->make(setup);
    names.push_back(kind->name);
  }
  throw datasets::InputError(fmt::format(
      "There is no executor '{}'; the executors are {}.", name, fmt::join(names, ", ")));
}

std::unique_ptr<Executor> make_executor(std::string_view name, int jobs) {
  return make_executor(name, ExecutorSetup{.jobs = jobs});
}

}  // namespace graintruth::calibrate
