// Rebound speed over impact speed.
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

extern constinit const ParameterKind restitution{
    .name = "restitution",
    .unit = "-",
    .units = plain,
    .range = {0.0, 1.0, false, "a restitution above 0 and at most 1"},
    .usual_lower = 0.1,
    .usual_upper = 1.0,
    .title = "Restitution",
    .phrase = "restitution",
    .neutral = 1.0,
    .is_always_stated = true,
    .bench_test = "a drop test of the particle",
    .bench_differs = "a drop test tells of one speed and one kind of contact",
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for (SceneSurfaces& surfaces : scene.surfaces) surfaces.restitution = value;
        },
    .value_in = [](std::string_view,
                   const SceneData& scene) { return on_all(scene, &SceneSurfaces::restitution); }};

}  // namespace graintruth::datasets
