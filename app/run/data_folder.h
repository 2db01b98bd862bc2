// Where the program finds the thesis's tables.
#pragma once

#include <filesystem>
#include <optional>

namespace graintruth::app {

// The folder datasets/: $GRAINTRUTH_DATA where set, else the first datasets/ or
// share/graintruth/datasets/ (where it is installed) with the thesis's tables upwards from the
// program. Throws datasets::InputError where there is none.
std::filesystem::path data_folder();

// The bundled file that says what a deck of this name leaves out; none for other decks.
std::optional<std::filesystem::path> bundled_sidecar(const std::filesystem::path& deck);

}  // namespace graintruth::app
