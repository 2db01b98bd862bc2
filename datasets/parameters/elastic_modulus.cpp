// Young's modulus of the grains.
#include "datasets/experiment/experiment.h"
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

// Of the materials that grains are made of.
std::optional<double> of_grains(const SceneData& scene) {
  std::optional<double> modulus;
  for (const SceneParticle& particle : scene.particles) {
    const double own = scene.materials[static_cast<std::size_t>(particle.material)].elastic_modulus;
    if (modulus && *modulus != own) return std::nullopt;
    modulus = own;
  }
  return modulus;
}

}  // namespace

extern constinit const ParameterKind elastic_modulus{
    .name = "elastic_modulus",
    .unit = "Pa",
    .units = pressure_units,
    .range = {0.0, 1e13, false, "a modulus above 0 and at most 10 TPa"},
    .usual_lower = 1e6,
    .usual_upper = 1e8,
    .title = "Modulus of elasticity",
    .phrase = "the modulus of elasticity",
    .stated_in = [](const Material& material) { return material.elastic_modulus; },
    .sets_stiffness = true,
    .bench_test = "a compression test of the particle's material",
    .bench_differs = "grains are often simulated softer than they are, to save time",
    .apply =
        [](double value, std::string_view, SceneData& scene) {
          for (const SceneParticle& particle : scene.particles)
            scene.materials[static_cast<std::size_t>(particle.material)].elastic_modulus = value;
        },
    .value_in = [](std::string_view, const SceneData& scene) { return of_grains(scene); }};

}  // namespace graintruth::datasets
