#include "calibrate/parameters.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace {

nlohmann::json read_result(const std::filesystem::path& file) {
  nlohmann::json json = nlohmann::json::parse(datasets::read_whole(file), nullptr, false);
  if (json.is_discarded()) {
    throw datasets::InputError(fmt::format(
        "{}: this is not valid JSON; give a result.json of this program.", file.string()));
  }
  return json;
}

ParameterSet parameters_of_result(const std::filesystem::path& file, ParameterSet parameters) {
  const nlohmann::json json = read_result(file);
  for (const datasets::ParameterKind* kind : datasets::parameter_kinds()) {
    const nlohmann::json::json_pointer value(fmt::format("/parameters/{}/value", kind->name));
    if (!kind->is_always_stated || (json.contains(value) && json[value].is_number())) continue;
    throw datasets::InputError(
        fmt::format("{}: parameters.{}.value is missing or no number.", file.string(), kind->name));
  }
  for (const auto& [name, parameter] : json["parameters"].items()) {
    if (datasets::find_parameter(name) && parameter.contains("value") &&
        parameter["value"].is_number())
      parameters.set(name, parameter["value"].get<double>());
  }
  return parameters;
}

bool is_json(const std::filesystem::path& file) { return file.extension() == ".json"; }

}  // namespace

ParameterSet load_parameters(const std::filesystem::path& file, const ParameterSet& bench) {
  if (is_json(file)) return parameters_of_result(file, bench);
  ParameterSet parameters = bench;
  for (const auto& [name, value] : datasets::read_parameter_table(file))
    parameters.set(name, value);
  return parameters;
}

std::optional<double> load_time_step_fraction(const std::filesystem::path& file) {
  if (!is_json(file)) return std::nullopt;
  const nlohmann::json json = read_result(file);
  const nlohmann::json::json_pointer fraction("/time_step/fraction");
  if (!json.contains(fraction) || !json[fraction].is_number()) return std::nullopt;
  return json[fraction].get<double>();
}

ParameterSet ParameterSpace::from_unit(const std::vector<double>& unit) const {
  ParameterSet parameters = base_;
  for (std::size_t i = 0; i < tuned_.size(); ++i) {
    const datasets::TunedParameter& tuned = tuned_[i];
    parameters.set(tuned.name, tuned.lower + unit[i] * (tuned.upper - tuned.lower));
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
  fixed.base_.set(name, value);
  std::erase_if(fixed.tuned_, [&](const auto& tuned) { return tuned.name == name; });
  return fixed;
}

}  // namespace graintruth::calibrate
