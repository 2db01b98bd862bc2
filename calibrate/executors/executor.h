// Where simulations run: on threads of this machine, or elsewhere. An executor is one file of this
// folder; one line of kinds.def makes it known by its name.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/engines/engine.h"
#include "datasets/experiment/execution.h"

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

// Simulations that nobody could run: what() is a sentence that names them.
struct TasksFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct ExecutorSetup {
  int jobs = 1;                   // threads of this machine
  datasets::Execution execution;  // of a batch system
  std::filesystem::path folder;   // its task folder
  std::filesystem::path program;  // that runs a task: PROGRAM run-task FOLDER INDEX
  std::string program_version;    // which the task's must be, too
  std::function<void(const std::string& sentence)> say;  // what the user should know; may be empty
};

struct ExecutorKind {
  std::string_view name;
  // Throws datasets::InputError where it cannot work here.
  std::unique_ptr<Executor> (*make)(const ExecutorSetup& setup);
};
// Makes one known that is not the program's own: a test's.
void make_known(const ExecutorKind& kind);

// Throws datasets::InputError for a name that none has.
std::unique_ptr<Executor> make_executor(std::string_view name, const ExecutorSetup& setup);
std::unique_ptr<Executor> make_executor(std::string_view name, int jobs);

// Runs `task(i)` for i in [0, count) on `jobs` threads. The first exception is rethrown after all
// threads have stopped.
void parallel_for(int count, int jobs, const std::function<void(int)>& task);

}  // namespace graintruth::calibrate
