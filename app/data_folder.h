// Where the program finds the thesis's tables.
#pragma once

#include <filesystem>

namespace graintruth::app {

// The folder datasets/: $GRAINTRUTH_DATA where set, else the first datasets/ or
// share/graintruth/datasets/ (where it is installed) with the thesis's tables upwards from the
// program. Throws datasets::InputError where there is none.
std::filesystem::path data_folder();

}  // namespace graintruth::app
