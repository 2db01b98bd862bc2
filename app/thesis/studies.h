// Simulations that a target needs, kept in the run folder: a study whose inputs have not changed is
// read back instead of being run again.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/progress.h"

namespace graintruth::app {

class Studies {
 public:
  using Json = nlohmann::ordered_json;

  Studies(std::filesystem::path folder, std::uint64_t seed, int jobs, ProgressLine& progress)
      : folder_(std::move(folder)), seed_(seed), jobs_(jobs), progress_(progress) {}

  // What `run` gives for these inputs: read from studies/<name>.json where it was stored for the
  // same inputs, seed and version of our numbers, else run and stored.
  Json result(const std::string& name, const std::string& inputs, const std::function<Json()>& run);
  // What is stored under that name for these inputs; null where nothing is.
  Json stored(const std::string& name, const std::string& inputs) const;

  // Runs task(0) ... task(count - 1) on several threads; each writes into its own place. Throws
  // calibrate::Interrupted after Ctrl-C.
  void in_parallel(int count, const std::function<void(int)>& task) const;

  std::uint64_t seed() const { return seed_; }
  std::filesystem::path folder() const { return folder_; }  // of the run
  ProgressLine& progress() { return progress_; }

 private:
  std::filesystem::path file_of(const std::string& name) const;
  std::string key_of(const std::string& inputs) const;

  std::filesystem::path folder_;
  std::uint64_t seed_;
  int jobs_;
  ProgressLine& progress_;
};

}  // namespace graintruth::app
