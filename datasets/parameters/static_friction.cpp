// What holds a contact until it slips for the first time; afterwards sliding friction counts.
#include <algorithm>

#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

constexpr Range range{0.0, 5.0, true, "a friction from 0 to 5"};
constexpr std::string_view rest =
    "a tilting test takes particles that have rested for long; those that just met hold less";

// A contact that slides already is not held by less than that.
void hold(double value, SceneSurfaces& surfaces) {
  surfaces.static_friction = std::max(value, surfaces.friction);
}

}  // namespace

extern constinit const ParameterKind static_friction_particle_particle{
    .name = "static_friction_particle_particle",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 1.0,
    .title = "Static friction, particle to particle",
    .phrase = "static friction between particles",
    .same_as = "friction_particle_particle",
    .bench_test = "a tilting test of particles on each other",
    .bench_differs = rest,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_particle(scene, [&](SceneSurfaces& surfaces) { hold(value, surfaces); });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particles(scene, &SceneSurfaces::static_friction);
        }};

extern constinit const ParameterKind static_friction_particle_wall{
    .name = "static_friction_particle_wall",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 1.0,
    .title = "Static friction, particle to wall",
    .phrase = "static friction between particles and walls",
    .same_as = "friction_particle_wall",
    .bench_test = "a tilting test of the particle on the wall",
    .bench_differs = rest,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_wall(scene, [&](SceneSurfaces& surfaces) { hold(value, surfaces); });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particle_and_wall(scene, &SceneSurfaces::static_friction);
        }};

}  // namespace graintruth::datasets
