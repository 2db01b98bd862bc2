#include "calibrate/engines/scratch_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>

#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const fs::path& place) : place_(place) {
  std::error_code error;
  if (!place.empty()) fs::create_directories(place, error);
  // Another run may remove the place just then, as empty
  for (int tries = 0; tries < 100; ++tries) {
    std::string name =
        ((place.empty() ? fs::temp_directory_path() : place) / "graintruth-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) {
      path_ = fs::absolute(name);
      return;
    }
    if (errno != ENOENT || place.empty()) break;
    fs::create_directories(place, error);
  }
  throw datasets::InputError(
      fmt::format("{}: no folder can be made there ({}).",
                  place.empty() ? fs::temp_directory_path().string() : place.string(),
                  std::strerror(errno)));
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (!place_.empty()) fs::remove(place_, ignored);
}

}  // namespace graintruth::calibrate
