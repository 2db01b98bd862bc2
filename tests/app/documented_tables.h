// The tables of a run folder against docs/run_folder.md: no file and no column that only one of
// them knows.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::tests {

// Every CSV file of the folder, and every documented one under these headings of the document:
// what is not the same in both, as sentences.
std::vector<std::string> undocumented_tables(const std::filesystem::path& run_folder,
                                             const std::vector<std::string>& headings);

}  // namespace graintruth::tests
