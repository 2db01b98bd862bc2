#include <algorithm>
#include <array>
#include <stdexcept>

#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

#define KIND(name) extern const ParameterKind name;
#include "datasets/parameters/kinds.def"
#undef KIND

namespace {

constexpr std::array all = {
#define KIND(name) &(name),
#include "datasets/parameters/kinds.def"
#undef KIND
};

std::size_t place_of(const ParameterKind* kind) {
  return static_cast<std::size_t>(std::find(all.begin(), all.end(), kind) - all.begin());
}

std::string with_wall(std::string_view words, std::string wall) {
  if (wall.empty()) return std::string(words);
  std::replace(wall.begin(), wall.end(), '_', ' ');
  return std::string(words) + " " + wall;
}

}  // namespace

std::string Parameter::title() const { return with_wall(kind->title, wall); }

std::string Parameter::phrase() const { return with_wall(kind->phrase, wall); }

std::span<const ParameterKind* const> parameter_kinds() { return all; }

std::optional<Parameter> find_parameter(std::string_view name) {
  for (const ParameterKind* kind : all) {
    if (!kind->is_of_a_wall && kind->name == name) return Parameter{kind, std::string(name), ""};
  }
  for (const ParameterKind* kind : all) {
    if (kind->is_of_a_wall && name.starts_with(kind->name) && name.size() > kind->name.size())
      return Parameter{kind, std::string(name), std::string(name.substr(kind->name.size()))};
  }
  return std::nullopt;
}

Parameter parameter_named(std::string_view name) {
  if (auto parameter = find_parameter(name)) return *std::move(parameter);
  throw std::logic_error("no such parameter: " + std::string(name));
}

bool comes_before(std::string_view first, std::string_view second) {
  const std::size_t a = place_of(parameter_named(first).kind);
  const std::size_t b = place_of(parameter_named(second).kind);
  return a != b ? a < b : first < second;
}

std::vector<std::string> plain_parameter_names() {
  std::vector<std::string> names;
  for (const ParameterKind* kind : all) {
    if (!kind->is_of_a_wall) names.emplace_back(kind->name);
  }
  return names;
}

}  // namespace graintruth::datasets
