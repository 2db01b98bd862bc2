// Walls as flat patches that can be drawn.
#pragma once

#include <vector>

#include "sim/shapes/walls.h"

namespace graintruth::app {

using Patch = std::vector<sim::Vec3>;

// What of a wall lies in a box: polygons and disks whole, cylinders as strips, segments across the
// depth of the box, planes as the part that passes through it. Empty for a wall that has opened.
std::vector<Patch> patches_of(const sim::Wall& wall, const sim::Box& box);

// The box of all walls with bounds and of planes across the axes, widened to hold the points, m.
sim::Box picture_box(const std::vector<sim::Wall>& walls, const std::vector<sim::Vec3>& points);

}  // namespace graintruth::app
