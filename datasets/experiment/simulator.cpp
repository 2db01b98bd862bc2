#include "datasets/experiment/simulator.h"

#include <fmt/format.h>

#include "datasets/store/fingerprint.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

std::string command_word(const std::string& word, const std::filesystem::path& folder) {
  const std::filesystem::path file = std::filesystem::absolute(folder / word).lexically_normal();
  std::error_code absent;
  return !word.empty() && std::filesystem::is_regular_file(file, absent) ? file.string() : word;
}

Simulator read_simulator(TomlSection& section, const std::filesystem::path& folder) {
  Simulator simulator;
  simulator.engine = section.optional_text("engine").value_or(simulator.engine);
  ForeignEngine& foreign = simulator.foreign;
  foreign.command = section.optional_texts("command").value_or(foreign.command);
  foreign.curves = section.optional_texts("curves").value_or(foreign.curves);
  foreign.ranks = section.optional_whole_number("ranks", 1, 4096).value_or(foreign.ranks);
  simulator.time_limit =
      section.optional_quantity("time_limit", time_limit_units, positive).value_or(0.0);
  const bool is_command = simulator.engine == "command";
  if (is_command && foreign.command.empty()) {
    section.fail("engine",
                 "is \"command\", which needs the program to run: command = [\"python3\", "
                 "\"my_simulator.py\"]");
  }
  for (const char* key : {"command", "curves"}) {
    if (!is_command && section.has(key))
      section.fail(key, "belongs to engine = \"command\" alone; leave it out");
  }
  std::string hashes;
  for (const std::string& word : foreign.command) {
    if (const std::string file = command_word(word, folder); file != word)
      hashes += file_hash(file);
  }
  if (is_command) foreign.command_hash = content_hash(hashes);
  section.finish();
  return simulator;
}

}  // namespace graintruth::datasets
