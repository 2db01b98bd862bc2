// Coulomb friction of surfaces that slide on each other.
#include <algorithm>

#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

constexpr Range range{0.0, 5.0, true, "a friction from 0 to 5"};
constexpr std::string_view tilting =
    "static friction, measured by tilting, is often well above that of particles in motion (the "
    "thesis tilted 0.36 and matched its films at 0.1)";

// Static friction, where it is stated, is not below it.
void slide(double value, SceneSurfaces& surfaces) {
  surfaces.friction = value;
  if (surfaces.static_friction > 0.0)
    surfaces.static_friction = std::max(surfaces.static_friction, value);
}

}  // namespace

extern constinit const ParameterKind friction_particle_particle{
    .name = "friction_particle_particle",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 0.7,
    .title = "Friction, particle to particle",
    .phrase = "friction between particles",
    .is_always_stated = true,
    .bench_test = "a sliding test of particles on each other",
    .bench_differs = tilting,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_particle(scene, [&](SceneSurfaces& surfaces) { slide(value, surfaces); });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particles(scene, &SceneSurfaces::friction);
        }};

extern constinit const ParameterKind friction_particle_wall{
    .name = "friction_particle_wall",
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 0.7,
    .title = "Friction, particle to wall",
    .phrase = "friction between particles and walls",
    .is_always_stated = true,
    .bench_test = "a sliding test of the particle on the wall",
    .bench_differs = tilting,
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for_particle_wall(scene, [&](SceneSurfaces& surfaces) { slide(value, surfaces); });
        },
    .value_in =
        [](std::string_view, const SceneData& scene) {
          return between_particle_and_wall(scene, &SceneSurfaces::friction);
        }};

// Of one wall, by its name in the rig.
extern constinit const ParameterKind friction_particle_surface{
    .name = "friction_particle_",
    .is_of_a_wall = true,
    .unit = "-",
    .units = plain,
    .range = range,
    .usual_upper = 0.7,
    .title = "Friction, particle to",
    .phrase = "friction between particles and the wall",
    .same_as = "friction_particle_wall",
    .bench_test = "a sliding test of the particle on this wall",
    .bench_differs = tilting,
    .apply =
        [](double value, std::string_view wall, SceneData& scene) {
          for_particle_on(wall, scene, [&](SceneSurfaces& surfaces) { slide(value, surfaces); });
        },
    .value_in =
        [](std::string_view wall, const SceneData& scene) {
          return on_wall(wall, scene, &SceneSurfaces::friction);
        }};

}  // namespace graintruth::datasets
