#include "app/scenes/scene_look.h"

#include <algorithm>
#include <cmath>

#include "app/scenes/wall_patches.h"

namespace graintruth::app {

sim::Box scene_box(const calibrate::SceneRun& run) {
  std::vector<sim::Wall> walls;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    if (run.frames[f].walls.empty()) continue;
    if (!walls.empty() && f + 1 < run.frames.size() && f % 8 != 0) continue;
    walls.insert(walls.end(), run.frames[f].walls.begin(), run.frames[f].walls.end());
  }
  sim::Box box = picture_box(walls, {});
  const sim::Box of_walls = box;
  const sim::Vec3 reach = 0.5 * (of_walls.high - of_walls.low);
  for (const calibrate::SceneFrame& frame : run.frames) {
    for (std::size_t i = 0; i < frame.state.position.size(); ++i) {
      const sim::Vec3& middle = frame.state.position[i];
      const double radius = run.scene.types[run.scene.bodies[i].type].bounding_radius;
      for (int axis = 0; axis < 3; ++axis) {
        const bool bounded = of_walls.low[axis] <= of_walls.high[axis];
        const double low = middle[axis] - radius, high = middle[axis] + radius;
        const double room = std::max(reach[axis], 2.0 * radius);
        const bool is_far = low < of_walls.low[axis] - room || high > of_walls.high[axis] + room;
        const bool is_between =
            middle[axis] >= of_walls.low[axis] && middle[axis] <= of_walls.high[axis];
        if (bounded &&
            ((is_far && &frame != &run.frames.front()) || (is_between && reach[axis] > 0.0))) {
          continue;
        }
        box.low[axis] = std::min(box.low[axis], low);
        box.high[axis] = std::max(box.high[axis], high);
      }
    }
  }
  return box;
}

std::vector<std::size_t> body_colours(const calibrate::SceneRun& run) {
  const std::size_t count = run.scene.bodies.size();
  std::vector<std::size_t> all(count);
  constexpr std::size_t few = 40;
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  const std::size_t bands = palette.size();
  if (count > few) {
    std::size_t frame = 0;
    while (frame + 1 < run.frames.size() && (run.frames[frame].state.position.size() < count ||
                                             run.frames[frame].state.time < run.event_time)) {
      ++frame;
    }
    const std::vector<sim::Vec3>& place = run.frames[frame].state.position;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const double low = a < place.size() ? place[a].z() : 0.0;
      const double high = b < place.size() ? place[b].z() : 0.0;
      return low != high ? low < high : a < b;
    });
  }
  for (std::size_t rank = 0; rank < count; ++rank) {
    all[order[rank]] = count > few ? rank * bands / count : rank % bands;
  }
  return all;
}

Sight spatial_sight() {
  using sim::Vec3;
  const double azimuth = 0.5, elevation = 0.42;  // rad
  const Vec3 ahead(std::sin(azimuth), std::cos(azimuth), 0.0);
  Sight sight;
  sight.right = Vec3(std::cos(azimuth), -std::sin(azimuth), 0.0);
  sight.away = std::cos(elevation) * ahead - std::sin(elevation) * Vec3::UnitZ();
  sight.up = std::sin(elevation) * ahead + std::cos(elevation) * Vec3::UnitZ();
  return sight;
}

}  // namespace graintruth::app
