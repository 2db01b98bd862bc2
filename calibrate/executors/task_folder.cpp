#include "calibrate/executors/task_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "calibrate/engines/recording_archive.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace fs = std::filesystem;
using datasets::InputError;
using datasets::Json;

template <class Archive>
void list_fields(Archive& archive, TaskManifest& manifest) {
  auto& [program_version,
         step_limit,
         threads,
         time_limit,
         folder,
         patience,
         attempt,
         canary,
         canary_bits,
         tasks] = manifest;
  archive("program_version", program_version)("step_limit", step_limit)("threads", threads);
  archive("time_limit_s", time_limit)("folder", folder)("patience_s", patience);
  archive("attempt", attempt)("canary", canary);
  archive("canary_bits", canary_bits)("tasks", tasks);
}

template <class Archive>
void list_fields(Archive& archive, TaskResult& result) {
  auto& [key, node, task_seconds, run] = result;
  archive("key", key)("node", node)("task_seconds", task_seconds)("run", run);
}

namespace {

constexpr std::string_view head = "graintruth result ";  // then the hash of all after this line

Json parsed(const fs::path& file) {
  Json json = Json::parse(datasets::read_whole(file), nullptr, false);
  if (json.is_discarded())
    throw InputError(fmt::format("{}: is not valid JSON; it was damaged.", file.string()));
  return json;
}

}  // namespace

fs::path TaskFolder::log(const std::string& name, int index) const {
  return root / "log" / fmt::format("{}-{}.txt", name, index);
}

void make_task_folder(const TaskFolder& folder) {
  for (const char* part : {"specs", "tmp", "done", "conflict", "refused", "damaged", "log"})
    datasets::make_folder(folder.root / part);
}

std::string to_text(const TaskManifest& manifest) { return datasets::to_json(manifest).dump(); }

std::string name_of(const TaskManifest& manifest) {
  return "graintruth-" + datasets::content_hash(to_text(manifest));
}

TaskManifest read_manifest(const fs::path& file) {
  const Json json = parsed(file);
  try {
    return datasets::from_json<TaskManifest>(json);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format(
        "{}: {}; it was written by another version of this program.", file.string(), error.what()));
  }
}

SimulationSpec read_spec(const TaskFolder& folder, const std::string& key) {
  const fs::path file = folder.spec(key);
  SimulationSpec spec;
  try {
    spec = spec_from_text(datasets::read_whole(file));
  } catch (const std::invalid_argument& error) {
    throw InputError(
        fmt::format("{}: {}; it was damaged, or written by another version of this "
                    "program.",
                    file.string(),
                    error.what()));
  }
  if (const std::string own = fingerprint_of(spec); own != key) {
    throw InputError(
        fmt::format("{}: the simulation in it has the fingerprint {}; it was damaged, or written "
                    "by another version of this program.",
                    file.string(),
                    own));
  }
  return spec;
}

std::string bits_of(const EngineRun& run) {
  EngineRun timeless = run;
  timeless.seconds = 0.0;
  return datasets::content_hash(datasets::to_json(timeless).dump());
}

bool put_result(const TaskFolder& folder, const TaskResult& result) {
  const std::string content = datasets::to_json(result).dump();
  const std::string name = fmt::format("{}.{}.{}", result.key, result.node, ::getpid());
  const fs::path temporary = folder.root / "tmp" / name;
  datasets::write_whole(temporary,
                        fmt::format("{}{}\n{}", head, datasets::content_hash(content), content));
  const fs::path place = folder.done(result.key);
  const bool is_first = ::link(temporary.c_str(), place.c_str()) == 0;
  const int error = errno;
  std::error_code ignored;
  if (!is_first && error == EEXIST) {
    std::string complaint;
    const auto first = read_result(place, result.key, complaint);
    if (first && bits_of(first->run) != bits_of(result.run)) {
      fs::rename(temporary, folder.root / "conflict" / name, ignored);
      return false;
    }
  }
  fs::remove(temporary, ignored);
  if (!is_first && error != EEXIST) {
    throw InputError(
        fmt::format("{}: cannot be written ({}).", place.string(), std::strerror(error)));
  }
  return true;
}

std::optional<TaskResult> read_result(const fs::path& file,
                                      const std::string& key,
                                      std::string& complaint) {
  try {
    const std::string text = datasets::read_whole(file);
    const std::size_t end = text.find('\n');
    if (!text.starts_with(head) || end == std::string::npos ||
        text.substr(head.size(), end - head.size()) !=
            datasets::content_hash(std::string_view(text).substr(end + 1))) {
      complaint = "its checksum is wrong";
      return std::nullopt;
    }
    auto result = datasets::from_json<TaskResult>(Json::parse(text.substr(end + 1)));
    if (result.key == key) return result;
    complaint = "it is of another simulation";
  } catch (const std::exception& error) {
    complaint = error.what();
  }
  return std::nullopt;
}

std::vector<std::string> files_of(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code absent;
  for (fs::directory_iterator at(folder, absent), end; !absent && at != end; at.increment(absent))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string node_name() {
  if (const char* name = std::getenv("SLURMD_NODENAME"); name != nullptr && *name != '\0')
    return name;
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  return host;
}

}  // namespace graintruth::calibrate
