#include "app/run/data_folder.h"

#include <cstdlib>

#include "datasets/scene/scene_file.h"
#include "datasets/store/input_error.h"

namespace graintruth::app {
namespace {

// Empty where there is none.
std::filesystem::path found_data_folder() {
  if (const char* given = std::getenv("GRAINTRUTH_DATA")) return given;
  std::error_code error;
  std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  while (!folder.empty()) {
    for (const char* place : {"datasets", "share/graintruth/datasets"})
      if (std::filesystem::is_directory(folder / place / "thesis", error)) return folder / place;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return {};
}

}  // namespace

std::filesystem::path data_folder() {
  if (std::filesystem::path found = found_data_folder(); !found.empty()) return found;
  throw datasets::InputError(
      "The folder datasets/ is not found above the program; set GRAINTRUTH_DATA to where it lies.");
}

std::optional<std::filesystem::path> bundled_sidecar(const std::filesystem::path& deck) {
  std::filesystem::path sidecar =
      found_data_folder() / "scenes" / "decks" / datasets::sidecar_beside(deck).filename();
  std::error_code error;
  if (!std::filesystem::is_regular_file(sidecar, error)) return std::nullopt;
  return sidecar;
}

}  // namespace graintruth::app
