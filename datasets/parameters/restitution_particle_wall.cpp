// Rebound speed over impact speed, where a particle meets a wall.
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

extern constinit const ParameterKind restitution_particle_wall{
    .name = "restitution_particle_wall",
    .unit = "-",
    .units = plain,
    .range = {0.0, 1.0, false, "a restitution above 0 and at most 1"},
    .usual_lower = 0.1,
    .usual_upper = 1.0,
    .title = "Restitution, particle to wall",
    .phrase = "restitution between particles and walls",
    .same_as = "restitution",
    .bench_test = "a drop test of the particle on a piece of the wall",
    .bench_differs = "a drop test tells of one speed and one kind of contact",
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_wall(scene, [&](SceneSurfaces& surfaces) { surfaces.restitution = value; });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particle_and_wall(scene, &SceneSurfaces::restitution);
        }};

}  // namespace graintruth::datasets
