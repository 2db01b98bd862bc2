// A run folder with made-up numbers: every file that a calibration leaves behind, plausible in
// shape, true in nothing.
#pragma once

#include <filesystem>

#include "datasets/store/run_folder.h"

namespace graintruth::tests {

// Writes the folder anew at the given place; the same numbers every time.
datasets::RunFolder write_fixture_run(const std::filesystem::path& root);

// The same of a flow through two orifices, the narrower held out.
datasets::RunFolder write_fixture_flow_run(const std::filesystem::path& root);

// The same of two experiments calibrated together, without their folders: one compared by its
// tracks, one by its flow with an orifice held out.
datasets::RunFolder write_fixture_run_of_several(const std::filesystem::path& root);

// The page as a reader would type it: with ordinary spaces.
std::string spoken(std::string page);

// What a reader sees who unfolds nothing: the text of the body without scripts, the contents of
// folds, and tags.
std::string visible_text(const std::string& page);
int words_in(const std::string& text);

int occurrences(const std::string& text, const std::string& part);

// An empty folder of its own for the running test, under the build's temporary folder.
std::filesystem::path empty_folder(const std::string& name);

}  // namespace graintruth::tests
