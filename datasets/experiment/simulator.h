// Which simulator an experiment is compared with: [simulation] of an experiment file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

// What decides the results of an engine that is another program.
struct ForeignEngine {
  std::vector<std::string> command;  // of the user's own; empty elsewhere
  std::string command_hash;          // of those of its words that are files
  std::vector<std::string> curves;   // that it records
  int ranks = 1;                     // of MPI; another number is another trajectory
};

struct Simulator {
  std::string engine = "embedded";
  ForeignEngine foreign;
  double time_limit = 0.0;  // s, for one run of another program; 0: none
};

class TomlSection;
Simulator read_simulator(TomlSection& section, const std::filesystem::path& folder);

// Where a word of a command names a file of this folder, that file; else the word.
std::string command_word(const std::string& word, const std::filesystem::path& folder);

}  // namespace graintruth::datasets
