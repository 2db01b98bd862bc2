// The folder through which a driver and the tasks of a batch system speak: specs in, results out.
//
//   specs/KEY        what to simulate; KEY is the fingerprint of the spec
//   ARRAY/           one job array: manifest.json, job.sh; ARRAY is the hash of the manifest
//   tmp/             results being written
//   done/KEY         results, each put there whole by link(): the first one stays
//   conflict/        results with other bits than the first one
//   refused/         nodes that give other bits for the known simulation
//   damaged/         results that did not pass their checksum
//   log/             what the tasks printed
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/engines/engine.h"

namespace graintruth::calibrate {

// What one job array is about.
struct TaskManifest {
  std::string program_version;
  std::int64_t step_limit = 0;  // as in EngineOptions
  int threads = 1;              // of one task
  double time_limit = 0.0;      // s; as in EngineOptions
  std::string folder;           // as in EngineOptions
  double patience = 0.0;        // s, for which a task tries again to write where the disk is full
  int attempt = 0;              // tells arrays of the same simulations apart
  std::string canary;           // a spec, which gives these bits
  std::string canary_bits;
  std::vector<std::vector<std::string>> tasks;  // the keys of each
};

struct TaskResult {
  std::string key, node;
  double task_seconds = 0.0;  // since the task began, on the clock of the wall
  EngineRun run;
};

struct TaskFolder {
  std::filesystem::path root;

  std::filesystem::path spec(const std::string& key) const { return root / "specs" / key; }
  std::filesystem::path done(const std::string& key) const { return root / "done" / key; }
  std::filesystem::path array(const std::string& name) const { return root / name; }
  std::filesystem::path manifest(const std::string& name) const {
    return root / name / "manifest.json";
  }
  std::filesystem::path log(const std::string& name, int index) const;
};

// Throws datasets::InputError where it cannot be made.
void make_task_folder(const TaskFolder& folder);

std::string to_text(const TaskManifest& manifest);
// The name of its array.
std::string name_of(const TaskManifest& manifest);
// Throws datasets::InputError that names the file and what is wrong with it.
TaskManifest read_manifest(const std::filesystem::path& file);
SimulationSpec read_spec(const TaskFolder& folder, const std::string& key);

// Puts a result where it belongs. False where another with other bits is there already: then this
// one goes to conflict/. Throws datasets::InputError where it cannot be written.
bool put_result(const TaskFolder& folder, const TaskResult& result);
// None, with the reason, where the file is not what was written.
std::optional<TaskResult> read_result(const std::filesystem::path& file,
                                      const std::string& key,
                                      std::string& complaint);
// A hash of all that decides: status, message, recording and step, not the time it took.
std::string bits_of(const EngineRun& run);

// The names of the files of a folder of it, sorted; none where it is not there.
std::vector<std::string> files_of(const std::filesystem::path& folder);

// The node that this process runs on.
std::string node_name();

}  // namespace graintruth::calibrate
