// The run folder of a verb: made where it was not there, held for this process alone, and gone
// again where nothing came of it.
#pragma once

#include <filesystem>
#include <string_view>

#include "app/run/made_folders.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/run_lock.h"

namespace graintruth::app {

// A run folder that is there, held as long as this lives. Throws datasets::InputError where another
// process is at work in it, or where it cannot be written. Prints a note where nobody can be kept
// out, unless `quiet`.
class Hold {
 public:
  Hold(const std::filesystem::path& root, std::string_view verb, bool quiet);

 private:
  datasets::RunLock lock_;
};

// The same of a folder that may have to be made, with its own folders in it. What a process that
// was killed had begun to write is removed.
class HeldFolder {
 public:
  HeldFolder(const std::filesystem::path& root, std::string_view verb, bool quiet);

  const datasets::RunFolder& folder() const { return folder_; }

 private:
  MadeFolders made_;  // goes last: the lock's file must be gone by then
  Hold hold_;
  datasets::RunFolder folder_;
};

}  // namespace graintruth::app
