// Where simulations run: [execution] of an experiment file. It decides nothing about results.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

struct Execution {
  std::string executor = "threads";
  // Of a batch system
  std::filesystem::path folder;      // that all nodes see; empty: tasks/ in the run folder
  std::string partition, account;    // empty: the cluster's own
  double time_limit = 0.0;           // s, of one task; 0: the partition's own
  int cpus = 1;                      // of one task
  std::vector<std::string> options;  // further ones, as the batch system takes them
  std::vector<std::string> set_up;   // lines of a shell before each task
  double task_seconds = 60.0;        // simulations are put together until they take so long
  double grace_seconds = 60.0;       // without result and queue, after which a task is lost
};

class TomlSection;
Execution read_execution(TomlSection& section, const std::filesystem::path& folder);

}  // namespace graintruth::datasets
