// The parameters of the model that a calibration may move, and the box it may move them in.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/experiment/experiment.h"
#include "datasets/parameters/parameter_set.h"

namespace graintruth::calibrate {

using datasets::ParameterSet;

inline double value_of(const ParameterSet& parameters, std::string_view name) {
  return parameters.of(name);
}

// Reads a result.json of ours or a TOML table of name = value; what it does not name stays at the
// bench value. A result.json must name those that every result has. The registry says which names
// and values there can be, in both. Throws datasets::InputError for any other.
ParameterSet load_parameters(const std::filesystem::path& file, const ParameterSet& bench);

// The time step fraction of a result.json; none where it states none, and in a TOML table. Throws
// datasets::InputError for an impossible one.
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
