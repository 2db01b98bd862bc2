// One task of a job array, on the node that the batch system gave it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace graintruth::calibrate {

struct TaskOptions {
  std::string program_version;
  std::function<bool()> stop;  // asked now and then; true: throw Interrupted
};

// Simulates what the manifest of `array` says of this index, and puts the results into the task
// folder, which is the one around it. Returns sentences on what went wrong but must not end the
// task: results with other bits than are there already. Throws datasets::InputError for another
// version of the program or of an engine, for specs whose fingerprint is another, and for a node
// that gives other bits for the known simulation.
std::vector<std::string> run_task(const std::filesystem::path& array,
                                  int index,
                                  const TaskOptions& options);

}  // namespace graintruth::calibrate
