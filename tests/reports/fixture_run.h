// A run folder with made-up numbers: every file that a calibration leaves behind, plausible in
// shape, true in nothing.
#pragma once

#include <filesystem>

#include "datasets/run_folder.h"

namespace graintruth::tests {

// Writes the folder anew at the given place; the same numbers every time.
datasets::RunFolder write_fixture_run(const std::filesystem::path& root);

// The same of a calibration on what runs out of a bin: two orifices, the narrower held out.
datasets::RunFolder write_fixture_flow_run(const std::filesystem::path& root);

// The same of a calibration on two experiments together, without the folders of these: one compared
// by its tracks, one by its flow with an orifice held out.
datasets::RunFolder write_fixture_joint_run(const std::filesystem::path& root);

// An empty folder of its own for the running test, under the build's temporary folder.
std::filesystem::path empty_folder(const std::string& name);

}  // namespace graintruth::tests
