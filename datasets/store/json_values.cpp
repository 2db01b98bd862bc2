#include "datasets/store/json_values.h"

#include <limits>

namespace graintruth::datasets {

namespace {

const Json absent;

}  // namespace

const Json& at(const Json& json, std::initializer_list<std::string_view> path) {
  const Json* here = &json;
  for (const std::string_view key : path) {
    if (!here->is_object()) return absent;
    const auto found = here->find(key);
    if (found == here->end()) return absent;
    here = &*found;
  }
  return *here;
}

double number(const Json& json, std::initializer_list<std::string_view> path) {
  const Json& value = at(json, path);
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string text(const Json& json, std::initializer_list<std::string_view> path) {
  const Json& value = at(json, path);
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number() || value.is_boolean()) return value.dump();
  return "";
}

const Json& list(const Json& json, std::initializer_list<std::string_view> path) {
  static const Json empty = Json::array();
  const Json& value = at(json, path);
  return value.is_array() ? value : empty;
}

std::vector<double> numbers(const Json& json, std::initializer_list<std::string_view> path) {
  std::vector<double> values;
  for (const Json& value : list(json, path)) values.push_back(number(value, {}));
  return values;
}

}  // namespace graintruth::datasets
