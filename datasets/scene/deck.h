// Input decks of the thesis (Appendix D), in their keyword language of centimetres and steps.
#pragma once

#include <filesystem>

#include "datasets/scene/scene_file.h"

namespace graintruth::datasets {

// Reads a deck and `sidecar`, a TOML file that says what decks leave out: moduli, units, and which
// reading of ambiguous commands is meant (docs/scene.md). Throws InputError with file, line and
// what is wrong; where keys of the sidecar are missing, with all of them.
SceneFile load_deck(const std::filesystem::path& file, const std::filesystem::path& sidecar);

}  // namespace graintruth::datasets
