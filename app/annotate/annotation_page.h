// The page of annotate: what the experiment file says so far, its films, and its rig as a drawing.
#pragma once

#include <filesystem>
#include <string>

namespace graintruth::app {

struct AnnotationPage {
  std::string html;
  std::string words;  // how many pictures of how many it shows
};

// Reads what of the experiment can be read by now: much of it may still be missing. `run_folder`
// may hold tracks of an earlier run. Throws datasets::InputError where a file is no TOML,
// contradicts itself, or a film cannot be read.
AnnotationPage make_annotation_page(const std::filesystem::path& experiment,
                                    const std::filesystem::path& run_folder);

}  // namespace graintruth::app
