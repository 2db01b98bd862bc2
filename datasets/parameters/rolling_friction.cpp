// Resistance against rolling: the greatest moment in a contact, over the normal force and the
// reduced radius of both bodies there (docs/theory.md).
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

constexpr Range range{0.0, 5.0, true, "a rolling friction from 0 to 5"};
constexpr std::string_view shape =
    "rolling friction stands for what the model's shape leaves out, so a bench value of one shape "
    "does not hold for another";

}  // namespace

extern constinit const ParameterKind rolling_friction_particle_particle{
    .name = "rolling_friction_particle_particle",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 0.3,
    .title = "Rolling friction, particle to particle",
    .phrase = "rolling friction between particles",
    .bench_test = "the angle of repose of a heap",
    .bench_differs = shape,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_particle(
              scene, [&](SceneSurfaces& surfaces) { surfaces.rolling_friction = value; });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particles(scene, &SceneSurfaces::rolling_friction);
        }};

extern constinit const ParameterKind rolling_friction_particle_wall{
    .name = "rolling_friction_particle_wall",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 0.3,
    .title = "Rolling friction, particle to wall",
    .phrase = "rolling friction between particles and walls",
    .bench_test = "a tilting test in which the particle rolls off a piece of the wall",
    .bench_differs = shape,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_wall(scene,
                            [&](SceneSurfaces& surfaces) { surfaces.rolling_friction = value; });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particle_and_wall(scene, &SceneSurfaces::rolling_friction);
        }};

}  // namespace graintruth::datasets
