#include "app/reproduce/studies.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "app/interrupt.h"
#include "calibrate/ensemble.h"
#include "calibrate/simulator.h"
#include "datasets/run_folder.h"

namespace graintruth::app {

namespace {

// Raised when the same inputs give other numbers, so that stored ones are not taken for them.
constexpr const char* numbers_version = "3";

// Nothing where the file is absent, of other inputs, or cannot be read.
nlohmann::ordered_json stored(const std::filesystem::path& file, const std::string& key) {
  if (!std::filesystem::exists(file)) return nullptr;
  const auto kept = nlohmann::ordered_json::parse(
      datasets::read_whole(file), nullptr, /*allow_exceptions=*/false);
  if (!kept.is_object() || kept.value("inputs", "") != key) return nullptr;
  return kept.value("result", nlohmann::ordered_json());
}

}  // namespace

Studies::Json Studies::result(const std::string& name,
                              const std::string& inputs,
                              const std::function<Json()>& run) {
  const std::filesystem::path file = folder_ / "studies" / (name + ".json");
  const std::string key =
      "numbers " + std::string(numbers_version) + "; seed " + std::to_string(seed_) + "; " + inputs;
  Json result = stored(file, key);
  if (!result.is_null()) return result;
  const auto start = std::chrono::steady_clock::now();
  progress_.show(name, 0.0, "");
  result = run();
  if (is_interrupted()) throw calibrate::Interrupted();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Json kept = {{"inputs", key}, {"seconds", seconds}, {"result", result}};
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
