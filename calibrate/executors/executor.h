// Where simulations run: on threads of this machine, or elsewhere. An executor is one file of this
// folder; one line of kinds.def makes it known by its name.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "calibrate/engines/engine.h"

namespace graintruth::calibrate {

struct SimulationTask {
  const Engine* engine = nullptr;
  SimulationSpec spec;
};

class Executor {
 public:
  virtual ~Executor() = default;
  // Runs all tasks, each with a retry where it becomes unstable, and calls `done` as each ends,
  // from any thread, several at once. The first exception of a task or of `done` is rethrown after
  // all have stopped.
  using Done = std::function<void(std::size_t task, EngineRun run)>;
  virtual void run(std::span<const SimulationTask> tasks,
                   const EngineOptions& options,
                   const Done& done) = 0;
};

struct ExecutorKind {
  std::string_view name;
  std::unique_ptr<Executor> (*make)(int jobs);
};
// Makes one known that is not the program's own: a test's.
void make_known(const ExecutorKind& kind);

// Throws datasets::InputError for a name that none has.
std::unique_ptr<Executor> make_executor(std::string_view name, int jobs);

// Runs `task(i)` for i in [0, count) on `jobs` threads. The first exception is rethrown after all
// threads have stopped.
void parallel_for(int count, int jobs, const std::function<void(int)>& task);

}  // namespace graintruth::calibrate
