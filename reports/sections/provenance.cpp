// Where the numbers come from, and how to get them again.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// A command given as text, or as an array of words.
std::string command_text(const RunData& data) {
  const Json& command = at(data.run, {"command"});
  if (!command.is_array()) return text(data.run, {"command"});
  std::string words;
  for (const Json& word : command) {
    if (!word.is_string()) continue;
    if (!words.empty()) words += ' ';
    words += word.get<std::string>();
  }
  return words;
}

TableView run_table(const RunData& data) {
  TableView table("The run", {{"What", Align::left}, {"Value", Align::left}});
  const auto add = [&](const char* what, const std::string& value) {
    if (!value.empty() && value != nothing) table.add_row({what, value});
  };
  add("Version of graintruth", text(data.run, {"version"}));
  add("Started", text(data.run, {"started_at"}));
  add("Seed", text(data.run, {"seed"}));
  add("Jobs at a time", text(data.run, {"jobs"}));
  add("Evaluations (parameter sets)", count(number(data.result, {"evaluations"})));
  add("Simulations (one seed each)", count(number(data.result, {"simulations"})));
  add("Failed simulations", count(number(data.result, {"failed"})));
  add("Wall time", seconds(number(data.result, {"wall_time_s"})));
  add("Status", text(data.result, {"status"}));
  add("Message", text(data.result, {"message"}));
  std::vector<std::string> replicates;
  for (const Json& name : list(data.measured, {"replicates"}))
    if (name.is_string()) replicates.push_back(name.get<std::string>());
  add("Replicates", joined(replicates));
  const Json& frames = list(data.measured, {"frames"});
  if (!frames.empty()) add("Frames compared", std::to_string(frames.size()));
  add("Particles", count(number(data.measured, {"particles"})));
  return table;
}

std::vector<std::string> missing_files(const RunData& data) {
  const datasets::RunFolder& folder = data.folder;
  std::vector<std::string> missing;
  std::vector<std::filesystem::path> expected = {folder.result()};
  if (!data.is_part()) expected.push_back(folder.journal());
  if (!data.is_of_several()) {
    expected.push_back(folder.measured());
    expected.push_back(folder.tracking());
  }
  for (const auto& file : expected)
    if (!std::filesystem::exists(file)) missing.push_back(file.filename().string());
  return missing;
}

// Told from an SQLite file's first hundred bytes (its file format, section 1.3): the name, the size
// of a page at byte 16, and the number of pages at byte 28, both with the highest byte first.
bool is_whole_journal(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 32> head{};
  if (!stream.read(head.data(), head.size())) return false;
  const auto whole = [&](std::size_t first, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = first; i < first + bytes; ++i)
      value = 256 * value + static_cast<unsigned char>(head[i]);
    return value;
  };
  if (std::string_view(head.data(), 15) != "SQLite format 3") return false;
  const std::uint64_t page = whole(16, 2) == 1 ? 65536 : whole(16, 2);
  return std::filesystem::file_size(file) >= page * whole(28, 4);
}

}  // namespace

Section provenance_section(const RunData& data, Section section) {
  if (data.run.is_null()) {
    section.add_absence(
        "run.json is absent or cannot be read: version, command, seeds and hashes are not known.");
  }
  if (const std::vector<std::string> missing = missing_files(data);
      !missing.empty() && !data.is_under_way()) {
    section.add_absence(fmt::format("The run folder lacks {}, which a finished run leaves there.",
                                    joined(missing)));
  }

  if (std::filesystem::exists(data.folder.journal()) && !is_whole_journal(data.folder.journal())) {
    section.add_absence(
        "journal.db was cut off or is no journal. journal.csv is a plain copy of its rows.");
  }

  const std::string command = command_text(data);
  if (command.empty()) {
    section.add_absence("The command of this run was not recorded.");
  } else {
    section.add_paragraph(
        "The same command with the same inputs and the same version gives the same numbers, with "
        "any number of jobs:");
    section.add_code(command);
  }
  section.begin_fold("Counts, inputs and times");
  section.add_paragraph(fmt::format(
      "This page was made from the run folder alone, and graintruth report makes it again. The "
      "folder's tables/ holds tables of the run as CSV, in SI units. Every simulation has a row in "
      "journal.csv{}.",
      data.is_part() ? " of the folder above it" : ""));
  section.add_table(run_table(data));
  const Json& hashes = at(data.run, {"input_hashes"});
  if (hashes.is_object() && !hashes.empty()) {
    TableView table("Hashes of the inputs", {{"File", Align::left}, {"Hash", Align::left}});
    for (const auto& [file, hash] : hashes.items())
      table.add_row({file, hash.is_string() ? hash.get<std::string>() : hash.dump()});
    section.add_table(table);
  }
  const Json& stages = list(data.run, {"stages"});
  if (!stages.empty()) {
    TableView table("Time of each stage", {{"Stage", Align::left}, {"Time"}});
    for (const Json& stage : stages)
      table.add_row({text(stage, {"name"}), seconds(number(stage, {"seconds"}))});
    section.add_table(table);
  }
  section.end_fold();
  const Json& configuration = at(data.run, {"configuration"});
  if (!configuration.is_null()) {
    section.add_folded_code("The resolved configuration",
                            configuration.dump(2, ' ', false, Json::error_handler_t::replace));
  }
  return section;
}

}  // namespace graintruth::reports
