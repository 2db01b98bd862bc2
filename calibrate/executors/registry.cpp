#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "calibrate/executors/kinds.h"
#include "datasets/input_error.h"

namespace graintruth::calibrate {

namespace {

constexpr std::array all = {
    &threads_executor,
};

}  // namespace

std::span<const ExecutorKind* const> executor_kinds() { return all; }

std::unique_ptr<Executor> make_executor(std::string_view name, int jobs) {
  std::vector<std::string_view> names;
  for (const ExecutorKind* kind : all) {
    if (kind->name == name) return kind->make(jobs);
    names.push_back(kind->name);
  }
  throw datasets::InputError(fmt::format(
      "There is no executor '{}'; the executors are {}.", name, fmt::join(names, ", ")));
}

}  // namespace graintruth::calibrate
