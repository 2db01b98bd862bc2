// Folders that a run makes are gone again when it came to nothing.
#pragma once

#include <filesystem>
#include <vector>

namespace graintruth::app {

// Removes, in the end, the folders that were made for this run and hold nothing.
class MadeFolders {
 public:
  explicit MadeFolders(const std::filesystem::path& root);
  ~MadeFolders();
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;

 private:
  std::vector<std::filesystem::path> made_;  // innermost first
};

}  // namespace graintruth::app
