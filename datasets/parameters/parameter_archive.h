// Parameter sets in the archives of store/archive.h: an object of name and value.
#pragma once

#include "datasets/parameters/parameter.h"
#include "datasets/parameters/parameter_set.h"
#include "datasets/store/archive.h"

namespace graintruth::datasets::archive_detail {

template <>
struct Converter<ParameterSet> {
  static Json write(ParameterSet& parameters) {
    Json json = Json::object();
    for (const auto& [name, value] : parameters) json[name] = number_json(value);
    return json;
  }
  static void read(const Json& json, ParameterSet& parameters, bool) {
    if (!json.is_object()) throw std::invalid_argument("must be an object of names and values");
    parameters = {};
    for (const auto& [name, value] : json.items()) {
      if (!find_parameter(name))
        throw std::invalid_argument(fmt::format("there is no parameter '{}'", name));
      parameters.set(name, number_of(value));
    }
  }
};

}  // namespace graintruth::datasets::archive_detail
