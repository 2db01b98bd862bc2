// The parameters of the model that a calibration may move, and the box it may move them in.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/experiment.h"

namespace graintruth::calibrate {

// Contact parameters of one simulation; particle-wall restitution equals particle-particle.
struct ParameterSet {
  double friction_particle_particle = 0.0;  // -
  double friction_particle_wall = 0.0;      // -
  double restitution = 1.0;                 // -
};

// The names of the parameters, in the order in which every table shows them.
inline constexpr std::array<std::string_view, 3> parameter_names = {
    "friction_particle_particle", "friction_particle_wall", "restitution"};

double& value_of(ParameterSet& parameters, std::string_view name);
double value_of(const ParameterSet& parameters, std::string_view name);

// The bench values of the experiment.
ParameterSet bench_parameters(const datasets::Experiment& experiment);

// Reads a result.json of ours or a TOML table of name = value; what it does not name stays at the
// bench value. Throws datasets::InputError for an unknown name or an impossible value.
ParameterSet load_parameters(const std::filesystem::path& file, const ParameterSet& bench);

// The time step fraction of a result.json; none in a TOML table.
std::optional<double> load_time_step_fraction(const std::filesystem::path& file);

// The box of the tuned parameters, seen as a unit cube. What is not tuned stays at its base value.
class ParameterSpace {
 public:
  ParameterSpace(std::vector<datasets::TunedParameter> tuned, const ParameterSet& base)
      : tuned_(std::move(tuned)), base_(base) {}

  std::size_t dimension() const { return tuned_.size(); }
  const std::vector<datasets::TunedParameter>& tuned() const { return tuned_; }
  ParameterSet from_unit(const std::vector<double>& unit) const;
  std::vector<double> to_unit(const ParameterSet& parameters) const;
  // The same space with one parameter held at a value.
  ParameterSpace with_fixed(std::string_view name, double value) const;

 private:
  std::vector<datasets::TunedParameter> tuned_;
  ParameterSet base_;
};

}  // namespace graintruth::calibrate
