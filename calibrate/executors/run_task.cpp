#include "calibrate/executors/run_task.h"

#include <fmt/format.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "calibrate/executors/executor.h"
#include "calibrate/executors/task_folder.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace {

namespace fs = std::filesystem;
using datasets::InputError;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void try_node(const TaskFolder& folder,
              const TaskManifest& manifest,
              const std::string& array,
              int index) {
  if (manifest.canary.empty()) return;
  const SimulationSpec spec = spec_from_text(manifest.canary);
  if (bits_of(engine_named(spec.engine).run(spec, {})) == manifest.canary_bits) return;
  const std::string node = node_name();
  datasets::write_whole(folder.root / "refused" / fmt::format("{}.{}.{}", array, index, node), "");
  throw InputError(
      fmt::format("node {} gives other bits for the known simulation than the machine of the "
                  "driver; its results would depend on the machine.",
                  node));
}

// A disk that is full may have room soon, and the result took long to make.
bool put_with_patience(const TaskFolder& folder,
                       const TaskResult& result,
                       double patience,
                       const std::function<bool()>& stop) {
  constexpr double between = 0.05;  // of the patience
  for (const auto start = Clock::now();;) {
    try {
      return put_result(folder, result);
    } catch (const InputError&) {
      if (seconds_since(start) > patience || (stop && stop())) throw;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(between * patience));
  }
}

}  // namespace

std::vector<std::string> run_task(const fs::path& array, int index, const TaskOptions& options) {
  const auto start = Clock::now();
  // 1. What is asked for, and whether this program may answer
  fs::path place = fs::absolute(array).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();  // of "folder/"
  const TaskFolder folder{place.parent_path()};
  const std::string name = place.filename().string();
  const TaskManifest manifest = read_manifest(folder.manifest(name));
  if (manifest.program_version != options.program_version) {
    throw InputError(
        fmt::format("{}: was written by version {} of this program, and this is version {}; use "
                    "the same program on all machines.",
                    folder.manifest(name).string(),
                    manifest.program_version,
                    options.program_version));
  }
  if (index < 0 || static_cast<std::size_t>(index) >= manifest.tasks.size()) {
    throw InputError(fmt::format("{}: has the tasks 0 to {}, but none of index {}.",
                                 folder.manifest(name).string(),
                                 static_cast<int>(manifest.tasks.size()) - 1,
                                 index));
  }
  try_node(folder, manifest, name, index);
  // 2. Each simulation, unless somebody has done it meanwhile
  const std::vector<std::string>& keys = manifest.tasks[static_cast<std::size_t>(index)];
  std::vector<std::string> complaints;
  std::mutex mutex;
  parallel_for(static_cast<int>(keys.size()), manifest.threads, [&](int i) {
    const std::string& key = keys[static_cast<std::size_t>(i)];
    if (fs::exists(folder.done(key))) return;
    const SimulationSpec spec = read_spec(folder, key);
    const Engine& engine = engine_named(spec.engine);
    if (engine.version() != spec.engine_version) {
      throw InputError(fmt::format(
          "{}: is for version {} of the engine '{}', and here is version {}; use the same program "
          "on all machines.",
          folder.spec(key).string(),
          spec.engine_version,
          spec.engine,
          engine.version()));
    }
    TaskResult result{.key = key, .node = node_name()};
    result.run = run_with_retry(engine,
                                spec,
                                {.step_limit = manifest.step_limit,
                                 .stop = options.stop,
                                 .time_limit = manifest.time_limit,
                                 .scratch = folder.root / "tmp",
                                 .folder = manifest.folder});
    result.task_seconds = seconds_since(start);
    if (put_with_patience(folder, result, manifest.patience, options.stop)) return;
    const std::lock_guard lock(mutex);
    complaints.push_back(fmt::format(
        "{}: another node gave other bits for this simulation; both results are kept", key));
  });
  return complaints;
}

}  // namespace graintruth::calibrate
