// What rigs have in common in which a few grains of one layer are followed while a slow face lets
// them down.
#pragma once

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

// Walls and the moving face, if there is one, into the scene; and how a run begins.
void follow_grains(const RigContext& context, Rig& rig);

// Segments as walls of the scene, all of one material.
SceneWall segment_of(const Wall& wall);

// Settling only has to bring the grains to rest, so its collisions are as dead as the model allows
// without stiffening the contact.
inline constexpr double settling_restitution = 0.2;

}  // namespace graintruth::datasets
