#include "app/export/exported_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "reports/page/run_data.h"
#include "sim/laws/time_step.h"

namespace graintruth::app {

namespace {

using reports::Json;

// A number above zero at a path of keys.
double positive(const std::filesystem::path& file,
                const Json& json,
                std::initializer_list<std::string_view> path) {
  const double value = reports::number(json, path);
  if (value > 0.0 && std::isfinite(value)) return value;
  throw datasets::InputError(fmt::format(
      "{}: {} is missing or not above zero; run the calibration again to have the file rewritten.",
      file.string(),
      fmt::join(path, ".")));
}

std::vector<sim::ElementSphere> read_spheres(const datasets::RunFolder& folder, const Json& run) {
  std::vector<sim::ElementSphere> spheres;
  for (const Json& sphere : reports::list(run, {"configuration", "particle", "spheres"})) {
    const double offset = reports::number(sphere, {"offset_m"});
    const double radius = reports::number(sphere, {"radius_m"});
    if (!std::isfinite(offset) || !(radius > 0.0)) {
      throw datasets::InputError(
          fmt::format("{}: configuration.particle.spheres holds a sphere without offset_m or "
                      "radius_m.",
                      folder.run().string()));
    }
    // Of those off the long axis
    const auto across = [&](std::string_view axis) {
      const double value = reports::number(sphere, {axis});
      return std::isfinite(value) ? value : 0.0;
    };
    spheres.push_back({sim::Vec3(offset, across("y_m"), across("z_m")), radius});
  }
  if (spheres.empty()) {
    throw datasets::InputError(
        fmt::format("{}: names no element spheres of the particle, so there is none to export; "
                    "'--to csv' writes what tracks there are.",
                    folder.run().string()));
  }
  return spheres;
}

// Of the run's particle. The inertia of a flat one is not that of the spheres that stand for it.
sim::MassChoice read_mass(const datasets::RunFolder& folder, const Json& run) {
  sim::MassChoice choice{.mass =
                             positive(folder.run(), run, {"configuration", "particle", "mass_kg"})};
  const auto& inertia = reports::list(run, {"configuration", "particle", "inertia_kg_m2"});
  if (inertia.empty()) return choice;
  sim::Vec3 moments = sim::Vec3::Zero();
  for (std::size_t i = 0; i < inertia.size() && i < 3; ++i)
    moments[i] = reports::number(inertia[i], {});
  if (inertia.size() != 3 || !(moments.minCoeff() > 0.0)) {
    throw datasets::InputError(
        fmt::format("{}: configuration.particle.inertia_kg_m2 must hold three numbers above zero.",
                    folder.run().string()));
  }
  choice.inertia = moments;
  return choice;
}

// Where grains are simulated softer than the experiment's, parameters and time step hold for those.
double simulated_modulus(const datasets::RunFolder& folder,
                         const reports::RunData& data,
                         double of_experiment) {
  if (!reports::at(data.result, {"simulated_elastic_modulus_pa"}).is_number()) return of_experiment;
  return positive(folder.result(), data.result, {"simulated_elastic_modulus_pa"});
}

double largest_radius(const sim::Clump& clump) {
  double radius = 0.0;
  for (const sim::ElementSphere& sphere : clump.spheres) radius = std::max(radius, sphere.radius);
  return radius;
}

}  // namespace

double ExportedRun::parameter(std::string_view name) const {
  if (parameters.has(name)) return parameters.of(name);
  const datasets::ParameterKind& kind = *datasets::parameter_named(name).kind;
  return kind.same_as.empty() ? kind.neutral : parameter(kind.same_as);
}

ExportedRun read_exported_run(const datasets::RunFolder& folder) {
  const reports::RunData data = reports::read_run_data(folder);
  if (!data.damage.empty())
    throw datasets::InputError(fmt::format("{}: {}", folder.root.string(), data.damage.front()));
  if (!data.result.is_object()) {
    throw datasets::InputError(fmt::format(
        "{}: is not there, so there are no parameters to export; let the calibration finish first.",
        folder.result().string()));
  }
  if (data.is_of_several()) {
    throw datasets::InputError(
        fmt::format("{}: is of several experiments, each with particles of its own; give the "
                    "folder of one of them in it.",
                    folder.root.string()));
  }
  ExportedRun run;
  run.parameters = calibrate::load_parameters(folder.result(), {});
  run.time_step = positive(folder.result(), data.result, {"time_step", "seconds"});
  run.gravity = positive(folder.run(), data.run, {"rig", "gravity_m_per_s2"});
  run.material_modulus =
      positive(folder.run(), data.run, {"configuration", "material", "elastic_modulus_pa"});
  run.material.youngs_modulus = run.parameters.value_or(
      "elastic_modulus", simulated_modulus(folder, data, run.material_modulus));
  run.material.poisson_ratio =
      reports::number(data.run, {"configuration", "material", "poisson_ratio"});
  const sim::MassChoice mass = read_mass(folder, data.run);
  run.has_own_inertia = mass.inertia.has_value();
  try {
    sim::check(run.material);
    sim::check(sim::Surfaces{.restitution = run.restitution()});
    run.particle = sim::make_clump(read_spheres(folder, data.run), mass);
  } catch (const std::invalid_argument& error) {
    throw datasets::InputError(
        fmt::format("{}: cannot be exported: {}.", folder.root.string(), error.what()));
  }
  return run;
}

Drop drop_of(const ExportedRun& run) {
  constexpr double steps_per_contact = 200.0;
  constexpr double durations = 10.0;
  Drop drop;
  const sim::Clump& clump = run.particle;
  bool is_axial = true;
  for (const sim::ElementSphere& sphere : clump.spheres)
    is_axial = is_axial && sphere.centre.y() == 0.0 && sphere.centre.z() == 0.0;
  for (std::size_t i = 0; i < clump.spheres.size(); ++i) {
    const auto& [centre, radius] = clump.spheres[i];
    const double reach = radius + (is_axial ? -centre.x() : centre.norm());
    if (reach > drop.touch_height) {
      drop.touch_height = reach;
      drop.sphere = i;
    }
  }
  // x to z, z to -x; or else what leads from the sphere's centre down
  drop.upright << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  const sim::Vec3& lands = clump.spheres[drop.sphere].centre;
  if (!is_axial && lands.norm() > 0.0) {
    drop.upright =
        Eigen::Quaterniond::FromTwoVectors(lands, -sim::Vec3::UnitZ()).toRotationMatrix();
  }
  drop.speed = std::sqrt(2.0 * run.gravity * 0.1 * 2.0 * largest_radius(clump));
  const double nu = run.material.poisson_ratio;
  const double modulus = run.material.youngs_modulus / (1.0 - nu * nu);  // against a rigid wall
  const double duration =
      sim::hertz_impact(modulus, clump.spheres[drop.sphere].radius, clump.mass, drop.speed)
          .duration;
  drop.start_height = drop.touch_height + drop.speed * duration;
  drop.time_step = std::min(run.time_step, duration / steps_per_contact);
  drop.steps = std::lround(durations * duration / drop.time_step);
  return drop;
}

}  // namespace graintruth::app
