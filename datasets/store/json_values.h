// Values of a JSON file, read tolerantly: an absent key, and null in place of a number, are facts
// that a reader can state. Brings in the JSON library; for .cpp files.
#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

using Json = nlohmann::ordered_json;  // keys stay in the order of their file

// The value at a path of keys; null where there is none.
const Json& at(const Json& json, std::initializer_list<std::string_view> path);
// NaN where there is no number.
double number(const Json& json, std::initializer_list<std::string_view> path);
// "" where there is no text; a number or a boolean is written out.
std::string text(const Json& json, std::initializer_list<std::string_view> path);
// Empty where there is no array.
const Json& list(const Json& json, std::initializer_list<std::string_view> path);
// An array of numbers, NaN for every other value in it; empty where there is no array.
std::vector<double> numbers(const Json& json, std::initializer_list<std::string_view> path);

}  // namespace graintruth::datasets
