// [[replicate]] of an experiment file. For the .cpp files of datasets alone.
#pragma once

#include <functional>

#include "datasets/experiment/experiment.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

// Reads the rig of one replicate, which may set some of its keys.
using ReadReplicateRig = std::function<Rig(TomlSection& replicate)>;

// The name of a replicate that states none, by its file: the stem; of pictures that a pattern names
// that of their folder.
std::string usual_name(const std::filesystem::path& file);

std::vector<Replicate> read_replicates(TomlSection& root,
                                       const std::filesystem::path& folder,
                                       Purpose purpose,
                                       const ReadReplicateRig& read_own_rig);

}  // namespace graintruth::datasets
