// graintruth new: an annotated experiment file to start from.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "app/run/assets.h"
#include "app/verbs/commands.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

constexpr std::string_view experiment_file = "experiment.toml";

// The files of a template lie in app/new/<name>. They load as they stand, once the films or tables
// that they name lie beside them.
std::vector<std::string> files_of(std::string_view name) {
  const std::string folder = fmt::format("new/{}/", name);
  std::vector<std::string> files;
  for (const std::string_view asset : asset_names()) {
    if (asset.starts_with(folder)) files.emplace_back(asset.substr(folder.size()));
  }
  return files;
}

}  // namespace

int run_new(const NewCommand& command) {
  const std::vector<std::string> files = files_of(command.kind);
  for (const std::string& name : files) {
    const std::filesystem::path file = command.folder / name;
    if (!std::filesystem::exists(file)) continue;
    throw datasets::InputError(fmt::format(
        "{}: is there already and is not overwritten; give another folder.", file.string()));
  }
  std::error_code error;
  std::filesystem::create_directories(command.folder, error);
  if (error) {
    throw datasets::InputError(fmt::format("{}: the folder cannot be made ({}); give another one.",
                                           command.folder.string(),
                                           error.message()));
  }
  for (const std::string& name : files) {
    datasets::write_whole(command.folder / name,
                          asset(fmt::format("new/{}/{}", command.kind, name)));
    fmt::print("{}\n", (command.folder / name).string());
  }
  fmt::print(
      "Put your films or tables beside it, replace its values by yours, then: graintruth "
      "check {}\n",
      (command.folder / experiment_file).string());
  return 0;
}

}  // namespace graintruth::app
