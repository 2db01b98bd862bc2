#include "app/run/held_folder.h"

#include <fmt/format.h>

#include <cstdio>

namespace graintruth::app {

namespace {

const std::filesystem::path& made(const std::filesystem::path& root) {
  datasets::make_folder(root);
  return root;
}

}  // namespace

Hold::Hold(const std::filesystem::path& root, std::string_view verb, bool quiet)
    : lock_(root, fmt::format("graintruth {}", verb)) {
  if (lock_.holds() || quiet) return;
  fmt::print(stderr,
             "Note: {}: this file system cannot lock files; see to it that no second process "
             "works in this folder.\n",
             root.string());
}

HeldFolder::HeldFolder(const std::filesystem::path& root, std::string_view verb, bool quiet)
    : made_(root), hold_(made(root), verb, quiet), folder_(datasets::open_run_folder(root)) {
  datasets::remove_unfinished(folder_);
}

}  // namespace graintruth::app
