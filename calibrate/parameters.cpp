#include "calibrate/parameters.h"

#include <stdexcept>

namespace graintruth::calibrate {

double& value_of(ParameterSet& parameters, std::string_view name) {
  if (name == parameter_names[0]) return parameters.friction_particle_particle;
  if (name == parameter_names[1]) return parameters.friction_particle_wall;
  if (name == parameter_names[2]) return parameters.restitution;
  throw std::logic_error("no such parameter: " + std::string(name));
}

double value_of(const ParameterSet& parameters, std::string_view name) {
  return value_of(const_cast<ParameterSet&>(parameters), name);
}

ParameterSet bench_parameters(const datasets::Experiment& experiment) {
  const datasets::Material& material = experiment.material;
  return {material.friction_particle_particle.value,
          material.friction_particle_wall.value,
          material.restitution.value};
}

ParameterSet ParameterSpace::from_unit(const std::vector<double>& unit) const {
  ParameterSet parameters = base_;
  for (std::size_t i = 0; i < tuned_.size(); ++i) {
    const datasets::TunedParameter& tuned = tuned_[i];
    value_of(parameters, tuned.name) = tuned.lower + unit[i] * (tuned.upper - tuned.lower);
  }
  return parameters;
}

std::vector<double> ParameterSpace::to_unit(const ParameterSet& parameters) const {
  std::vector<double> unit(tuned_.size());
  for (std::size_t i = 0; i < tuned_.size(); ++i) {
    const datasets::TunedParameter& tuned = tuned_[i];
    unit[i] = (value_of(parameters, tuned.name) - tuned.lower) / (tuned.upper - tuned.lower);
  }
  return unit;
}

ParameterSpace ParameterSpace::with_fixed(std::string_view name, double value) const {
  ParameterSpace fixed = *this;
  value_of(fixed.base_, name) = value;
  std::erase_if(fixed.tuned_, [&](const auto& tuned) { return tuned.name == name; });
  return fixed;
}

}  // namespace graintruth::calibrate
