// Runs a program and says what it cost: CPU time and memory of the process, as the system counts
// them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::bench {

struct ProcessCost {
  double cpu_time = 0.0;  // s; user and system, of the process and the children it waited for
  double peak_memory_mib = 0.0;  // largest resident set
};

// Runs `command` (found by PATH) in `folder`; what it prints goes to `log` in that folder. Throws
// std::runtime_error with the end of the log when the program fails.
ProcessCost run_program(const std::vector<std::string>& command,
                        const std::filesystem::path& folder,
                        const std::string& log);

// Is there an executable file of this name on PATH?
bool is_installed(const std::string& program);

}  // namespace graintruth::bench
