#include "app/data_folder.h"

#include <cstdlib>

#include "datasets/input_error.h"

namespace graintruth::app {

std::filesystem::path data_folder() {
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
  throw datasets::InputError(
      "The folder datasets/ is not found above the program; set GRAINTRUTH_DATA to where it lies.");
}

}  // namespace graintruth::app
