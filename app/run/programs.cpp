#include "app/run/programs.h"

#include <fmt/format.h>

#include "datasets/store/input_error.h"

namespace graintruth::app {

namespace {

namespace fs = std::filesystem;

fs::path this_program() {
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown);
}

}  // namespace

fs::path whole_program() {
  const fs::path folder = this_program().parent_path();
  for (const fs::path& place : {folder, folder.parent_path() / "libexec/graintruth"}) {
    std::error_code absent;
    if (fs::exists(place / "graintruth-whole", absent)) return place / "graintruth-whole";
  }
  throw datasets::InputError(
      fmt::format("{}: graintruth-whole, which does the work of this verb, is not there, nor in "
                  "libexec/graintruth; install the program anew.",
                  folder.string()));
}

fs::path light_program() {
  const fs::path own = this_program(), folder = own.parent_path();
  for (const fs::path& place : {folder, folder.parent_path().parent_path() / "bin"}) {
    std::error_code absent;
    if (fs::exists(place / "graintruth", absent)) return place / "graintruth";
  }
  return own;
}

}  // namespace graintruth::app
