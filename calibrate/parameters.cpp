#include "calibrate/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using Json = nlohmann::json;

Json read_result(const std::filesystem::path& file) {
  Json json = Json::parse(datasets::read_whole(file), nullptr, false);
  if (json.is_discarded()) {
    throw InputError(fmt::format("{}: this is not valid JSON; give a result.json of this program.",
                                 file.string()));
  }
  return json;
}

// A number that can be, by the rule that holds for TOML tables too. `key` is its path in the file.
double number_of(const std::filesystem::path& file,
                 const std::string& key,
                 const Json& value,
                 const datasets::Range& range) {
  const auto refuse = [&](const std::string& complaint) {
    throw InputError(fmt::format("{}: key '{}' {}.", file.string(), key, complaint));
  };
  if (!value.is_number()) {
    refuse(fmt::format(
        "holds {}, but {} is needed", value.is_string() ? "text" : "no number", range.words));
  }
  const auto number = value.get<double>();
  if (const auto complaint = datasets::complaint_about(number, number, range)) refuse(*complaint);
  return number;
}

ParameterSet parameters_of_result(const std::filesystem::path& file, ParameterSet parameters) {
  const Json json = read_result(file);
  const auto all = json.is_object() ? json.find("parameters") : json.end();
  if (all == json.end() || !all->is_object()) {
    throw InputError(fmt::format(
        "{}: key 'parameters' is missing or no table; give a result.json of this program.",
        file.string()));
  }
  for (const datasets::ParameterKind* kind : datasets::parameter_kinds()) {
    if (!kind->is_always_stated || all->contains(kind->name)) continue;
    throw InputError(fmt::format("{}: key 'parameters.{}' is missing.", file.string(), kind->name));
  }
  for (const auto& [name, given] : all->items()) {
    const auto parameter = datasets::find_parameter(name);
    const std::string key = "parameters." + name;
    if (!parameter) {
      throw InputError(fmt::format("{}: key '{}' is unknown; known here are {}.",
                                   file.string(),
                                   key,
                                   fmt::join(datasets::plain_parameter_names(), ", ")));
    }
    const auto value = given.is_object() ? given.find("value") : given.end();
    if (!given.is_object() || value == given.end())
      throw InputError(fmt::format("{}: key '{}.value' is missing.", file.string(), key));
    parameters.set(name, number_of(file, key + ".value", *value, parameter->kind->range));
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
  const Json json = read_result(file);
  const auto step = json.is_object() ? json.find("time_step") : json.end();
  if (step == json.end()) return std::nullopt;
  if (!step->is_object())
    throw InputError(fmt::format("{}: key 'time_step' is no table.", file.string()));
  const auto fraction = step->find("fraction");
  if (fraction == step->end()) return std::nullopt;
  return number_of(file, "time_step.fraction", *fraction, datasets::step_fraction);
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
