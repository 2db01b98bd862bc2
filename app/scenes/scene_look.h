// What every picture of a scene shows alike: which part of it, and which colour each body has.
#pragma once

#include <array>
#include <vector>

#include "calibrate/engines/scene_run.h"

namespace graintruth::app {

// Everything that should be in the picture: bounded walls, the particles at the start, and those
// that stay near the walls later.
sim::Box scene_box(const calibrate::SceneRun& run);

// Red, green, blue, 0 to 255.
inline constexpr std::array<std::array<int, 3>, 6> palette = {{{76, 120, 168},
                                                               {245, 146, 78},
                                                               {114, 183, 178},
                                                               {220, 87, 87},
                                                               {98, 172, 92},
                                                               {238, 202, 84}}};

// Index into the palette of each body, by the place in the filling: few particles in turn, many in
// layers by their height at the start.
std::vector<std::size_t> body_colours(const calibrate::SceneRun& run);

// Where a scene in space is seen from: from the front left, a little from above. Unit vectors.
struct Sight {
  sim::Vec3 right = sim::Vec3::UnitX(), up = sim::Vec3::UnitZ(), away = sim::Vec3::UnitY();
};
Sight spatial_sight();

}  // namespace graintruth::app
