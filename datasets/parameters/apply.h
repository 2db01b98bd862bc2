// Which surfaces of a scene a parameter sets.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "datasets/parameters/parameter_set.h"
#include "datasets/scene/scene_file.h"

namespace graintruth::datasets {

// Sets every parameter of the set in the scene, in the order of the registry.
void apply_parameters(const ParameterSet& parameters, SceneData& scene);

// Surfaces between particles, and between a particle and anything else.
void for_particle_particle(SceneData& scene, const std::function<void(SceneSurfaces&)>& set);
void for_particle_wall(SceneData& scene, const std::function<void(SceneSurfaces&)>& set);
// Surfaces between particles and the walls of this name: the wall itself, or all of `name`_... such
// as the sides of a box. The walls get a material of their own if they share theirs.
void for_particle_on(std::string_view wall,
                     SceneData& scene,
                     const std::function<void(SceneSurfaces&)>& set);
// One member of the surfaces that the functions above set, where all of them agree.
using Member = double SceneSurfaces::*;
std::optional<double> between_particles(const SceneData& scene, Member member);
std::optional<double> between_particle_and_wall(const SceneData& scene, Member member);
std::optional<double> on_wall(std::string_view wall, const SceneData& scene, Member member);
std::optional<double> on_all(const SceneData& scene, Member member);

// Whether the scene has such a wall.
bool has_wall(const SceneData& scene, std::string_view wall);

}  // namespace graintruth::datasets
