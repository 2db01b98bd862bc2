// Slurm's commands. One that is slow or fails is waited for, and said; none of them is believed
// about results.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/execution.h"

namespace graintruth::calibrate {

// One task of an array that is in the queue.
struct QueuedTask {
  std::string array;  // its name
  std::string id;     // <job>_<index>
  int index = 0;
  bool runs = false;
  bool is_stuck = false;  // held, or nobody will start it
  std::string reason;     // as Slurm calls it
  double elapsed = 0.0;   // s, since it began to run
};

class SlurmQueue {
 public:
  using Say = std::function<void(const std::string&)>;
  SlurmQueue(datasets::Execution execution, Say say);

  // Throws datasets::InputError where Slurm's commands are not installed.
  void require_commands() const;
  // Whether the array was accepted; where not, ask again later: it may have been all the same.
  // Throws datasets::InputError with Slurm's own words for what it will never accept.
  bool submit(const std::string& array,
              std::size_t tasks,
              const std::filesystem::path& script,
              const std::string& log_pattern,
              const std::vector<std::string>& excluded_nodes);
  // What is in the queue of these arrays. None where Slurm does not answer.
  std::optional<std::vector<QueuedTask>> look(const std::vector<std::string>& arrays);
  // One task by its id, or all of an array by its name. What is not there any more is no matter.
  void cancel_task(const std::string& id);
  void cancel_array(const std::string& array);

 private:
  struct Answer {
    bool came = false;
    std::string out, trouble;
  };
  Answer ask(const std::vector<std::string>& words);

  datasets::Execution execution_;
  Say say_;
  std::string silent_;          // the command that did not answer last time
  std::string last_complaint_;  // of sbatch
};

// [days-]hours:minutes:seconds, as Slurm writes it, in seconds.
double seconds_of(const std::string& slurm_time);
// What squeue printed in the form that `look` asks for.
std::vector<QueuedTask> read_queue(const std::string& printed);

}  // namespace graintruth::calibrate
