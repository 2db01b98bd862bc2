#include "app/run/made_folders.h"

#include <system_error>

namespace graintruth::app {

MadeFolders::MadeFolders(const std::filesystem::path& root) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(root, error).lexically_normal();
  std::filesystem::path folder = whole.has_filename() ? whole : whole.parent_path();
  for (const char* inside : {"tables", "tracks"}) {
    if (!std::filesystem::exists(folder / inside, error)) made_.push_back(folder / inside);
  }
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path()) {
    made_.push_back(folder);
    folder = folder.parent_path();
  }
}

MadeFolders::~MadeFolders() {
  for (const std::filesystem::path& folder : made_) {
    std::error_code error;
    if (std::filesystem::is_empty(folder, error) && !error) std::filesystem::remove(folder, error);
  }
}

}  // namespace graintruth::app
