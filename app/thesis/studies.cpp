#include "app/thesis/studies.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "app/run/interrupt.h"
#include "calibrate/compare/simulated_run.h"
#include "calibrate/ensemble.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

// Raised when the same inputs give other numbers, so that stored ones are not taken for them.
constexpr const char* numbers_version = "3";

}  // namespace

std::filesystem::path Studies::file_of(const std::string& name) const {
  return folder_ / "studies" / (name + ".json");
}

std::string Studies::key_of(const std::string& inputs) const {
  return "numbers " + std::string(numbers_version) + "; seed " + std::to_string(seed_) + "; " +
         inputs;
}

// Nothing where the file is absent, of other inputs, cannot be read, or was changed.
Studies::Json Studies::stored(const std::string& name, const std::string& inputs) const {
  const std::filesystem::path file = file_of(name);
  if (!std::filesystem::exists(file)) return nullptr;
  const auto kept = Json::parse(datasets::read_whole(file), nullptr, /*allow_exceptions=*/false);
  if (!kept.is_object() || kept.value("inputs", "") != key_of(inputs)) return nullptr;
  Json result = kept.value("result", Json());
  if (kept.value("checksum", "") != datasets::content_hash(result.dump())) {
    progress_.say(
        fmt::format("Note: {} was changed after it was written, or is of an earlier "
                    "version; it is made again.",
                    file.string()));
    return nullptr;
  }
  return result;
}

Studies::Json Studies::result(const std::string& name,
                              const std::string& inputs,
                              const std::function<Json()>& run) {
  Json result = stored(name, inputs);
  if (!result.is_null()) return result;
  const auto start = std::chrono::steady_clock::now();
  progress_.show(name, 0.0, "");
  result = run();
  if (is_interrupted()) throw calibrate::Interrupted();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::filesystem::path file = file_of(name);
  const Json kept = {{"inputs", key_of(inputs)},
                     {"seconds", seconds},
                     {"checksum", datasets::content_hash(result.dump())},
                     {"result", result}};
  std::filesystem::create_directories(file.parent_path());
  datasets::write_whole(file, kept.dump(1) + "\n");
  // As it will be read back, so that a run and its repetition give the same digits.
  return Json::parse(result.dump());
}

void Studies::in_parallel(int count, const std::function<void(int)>& task) const {
  calibrate::parallel_for(count, jobs_, [&](int i) {
    if (is_interrupted()) throw calibrate::Interrupted();
    task(i);
  });
}

}  // namespace graintruth::app
