// The shape of a particle, as scene files and experiment files state it.
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/scene/scene_file.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

// Exactly one of radius, spheres, chain, profile and sphere_file. Files are looked for in `folder`
// and added to `inputs`.
void read_particle_shape(TomlSection& section,
                         const std::filesystem::path& folder,
                         std::vector<std::filesystem::path>& inputs,
                         SceneParticle& particle);

// Throws InputError where the spheres of a planar scene's particle lie in several layers.
void require_one_layer(TomlSection& section, const SceneParticle& particle);

SizeSpread read_size_spread(TomlSection section);

// The length in m of the unit that a key names: "m", "cm" or "mm".
double read_length_unit(TomlSection& section, std::string_view key);

}  // namespace graintruth::datasets
