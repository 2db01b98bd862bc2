// Another program, run to its end: what it printed, and how it ended.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

struct ExternalCall {
  std::vector<std::string> words;  // the program, found in PATH where it has no '/'; its arguments
  std::filesystem::path folder;    // to run in; empty: this one
  std::map<std::string, std::string> environment = {};  // on top of this program's own
  double time_limit = 0.0;                              // s, beyond which it is ended; 0: none
  std::function<bool()> stop = {};                      // asked now and then; true: it is ended
};

struct ExternalEnd {
  enum class How { by_itself, by_signal, not_started, too_late, stopped };
  How how = How::by_itself;
  int status = -1;  // its exit status, or the number of the signal
  std::string out;  // the last 64 kB of what it printed
  std::string err;
  bool succeeded() const { return how == How::by_itself && status == 0; }
  // "ended with status 3", "was ended by signal 9", ...; a phrase for a sentence
  std::string words() const;
};

// Never throws for what the program does. What it has started goes with it, and it ends with this
// program, however that ends.
ExternalEnd run_external(const ExternalCall& call);

// Where PATH finds a program.
std::optional<std::filesystem::path> find_program(std::string_view name);

}  // namespace graintruth::datasets
