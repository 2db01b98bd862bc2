// A folder for the files of one run of another program, gone with it.
#pragma once

#include <filesystem>

namespace graintruth::calibrate {

class ScratchFolder {
 public:
  // Below `place`, which is made where it is not there; empty: the system's folder for such. Throws
  // datasets::InputError where none can be made.
  explicit ScratchFolder(const std::filesystem::path& place);
  // Removes `place` too where nothing else is in it.
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path place_, path_;
};

}  // namespace graintruth::calibrate
