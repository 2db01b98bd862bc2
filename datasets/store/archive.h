// Plain data as JSON and back, by one listing of its fields: what is written, what is read and what
// a fingerprint is made of can not differ. For .cpp files alone, because it brings in the JSON
// library.
//
// A listing stands beside its type and takes it apart by a structured binding, so that a new field
// does not compile until it is listed:
//
//   template <class Archive>
//   void list_fields(Archive& archive, Pose& pose) {
//     auto& [x, z, angle] = pose;
//     archive("x", x)("z", z)("angle", angle);
//   }
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace graintruth::datasets {

using Json = nlohmann::ordered_json;  // keys in the order in which they are listed

// The words of an enumeration, in the order of its values: specialise with `words`.
template <class Enum>
struct EnumWords;

namespace archive_detail {

template <class T>
inline constexpr bool is_number = std::is_arithmetic_v<T>;
template <class T>
inline constexpr bool is_text =
    std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>;

}  // namespace archive_detail

// Numbers that are not finite have words in JSON: null for NaN, "inf" and "-inf".
class JsonWriter {
 public:
  template <class T>
  JsonWriter& operator()(const char* name, T& value) {
    json_[name] = written(value);
    return *this;
  }
  // What is not there is not written.
  template <class T>
  JsonWriter& operator()(const char* name, std::optional<T>& value) {
    if (value) json_[name] = written(*value);
    return *this;
  }
  Json take() { return std::move(json_); }

  template <class T>
  static Json written(T& value);

 private:
  Json json_ = Json::object();
};

// What does not fit throws std::invalid_argument that names the field. A field that is not there
// keeps its default where `missing_keeps_default`, and is refused elsewhere.
class JsonReader {
 public:
  explicit JsonReader(const Json& json, bool missing_keeps_default = false)
      : json_(json), missing_keeps_default_(missing_keeps_default) {}

  template <class T>
  JsonReader& operator()(const char* name, T& value) {
    const auto found = json_.is_object() ? json_.find(name) : json_.end();
    if (found == json_.end()) {
      if (missing_keeps_default_) return *this;
      throw std::invalid_argument(fmt::format("'{}' is missing", name));
    }
    try {
      read(*found, value, missing_keeps_default_);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}: {}", name, error.what()));
    }
    return *this;
  }

  template <class T>
  JsonReader& operator()(const char* name, std::optional<T>& value) {
    value.reset();
    if (!json_.is_object() || !json_.contains(name)) return *this;
    value = T{};
    return (*this)(name, *value);
  }

  template <class T>
  static void read(const Json& json, T& value, bool missing_keeps_default);

 private:
  const Json& json_;
  bool missing_keeps_default_;
};

// A list or a text that is not written where it is empty: what came later leaves the text of what
// does not have it, and with it its fingerprint, as it was.
template <class Archive, class T>
void list_if_any(Archive& archive, const char* name, T& value) {
  std::optional<T> some;
  if (!value.empty()) some = value;
  archive(name, some);
  if constexpr (std::is_same_v<Archive, JsonReader>) value = std::move(some).value_or(T{});
}

// Things of surfaces, each with its name in `surface`: the one of a rig with one surface, which has
// no name, as "outline"; those with names as a list.
template <class Archive, class T>
void list_surfaces(Archive& archive, std::vector<T>& things) {
  std::optional<T> only;
  std::vector<T> named;
  for (const T& thing : things) {
    if (thing.surface.empty()) {
      only = thing;
    } else {
      named.push_back(thing);
    }
  }
  archive("outline", only);
  list_if_any(archive, "surfaces", named);
  if constexpr (std::is_same_v<Archive, JsonReader>) {
    things = std::move(named);
    if (only) things.insert(things.begin(), *std::move(only));
  }
}

template <class T>
Json to_json(const T& value) {
  return JsonWriter::written(const_cast<T&>(value));
}

template <class T>
T from_json(const Json& json, bool missing_keeps_default = false) {
  T value{};
  JsonReader::read(json, value, missing_keeps_default);
  return value;
}

namespace archive_detail {

inline Json number_json(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  return value;
}

inline double number_of(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (json.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (json == "inf") return std::numeric_limits<double>::infinity();
  if (json == "-inf") return -std::numeric_limits<double>::infinity();
  throw std::invalid_argument("must be a number");
}

template <class T>
struct Converter {  // of a structure with a listing
  static Json write(T& value) {
    JsonWriter writer;
    list_fields(writer, value);
    return writer.take();
  }
  static void read(const Json& json, T& value, bool missing_keeps_default) {
    if (!json.is_object()) throw std::invalid_argument("must be an object");
    JsonReader reader(json, missing_keeps_default);
    list_fields(reader, value);
  }
};

template <class T>
requires(is_number<T>) struct Converter<T> {
  static Json write(T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      return number_json(value);
    } else {
      return value;
    }
  }
  static void read(const Json& json, T& value, bool) {
    if constexpr (std::is_floating_point_v<T>) {
      value = number_of(json);
    } else if constexpr (std::is_same_v<T, bool>) {
      if (!json.is_boolean()) throw std::invalid_argument("must be true or false");
      value = json.get<bool>();
    } else {
      if (!json.is_number_integer()) throw std::invalid_argument("must be a whole number");
      value = json.get<T>();
    }
  }
};

template <class T>
requires(is_text<T>) struct Converter<T> {
  static Json write(T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      return value;
    } else {
      return value.string();
    }
  }
  static void read(const Json& json, T& value, bool) {
    if (!json.is_string()) throw std::invalid_argument("must be a text");
    value = json.get<std::string>();
  }
};

template <class T>
requires(std::is_enum_v<T>) struct Converter<T> {
  static Json write(T& value) { return EnumWords<T>::words.at(static_cast<std::size_t>(value)); }
  static void read(const Json& json, T& value, bool) {
    const auto& words = EnumWords<T>::words;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (json != words[i]) continue;
      value = static_cast<T>(i);
      return;
    }
    throw std::invalid_argument(
        fmt::format("must be one of {}", fmt::join(words.begin(), words.end(), ", ")));
  }
};

template <class T>
struct Converter<std::vector<T>> {
  static Json write(std::vector<T>& values) {
    Json json = Json::array();
    for (T& value : values) json.push_back(JsonWriter::written(value));
    return json;
  }
  static void read(const Json& json, std::vector<T>& values, bool missing_keeps_default) {
    if (!json.is_array()) throw std::invalid_argument("must be a list");
    values.clear();
    for (const Json& one : json)
      JsonReader::read(one, values.emplace_back(), missing_keeps_default);
  }
};

template <class T, std::size_t count>
struct Converter<std::array<T, count>> {
  static Json write(std::array<T, count>& values) {
    Json json = Json::array();
    for (T& value : values) json.push_back(JsonWriter::written(value));
    return json;
  }
  static void read(const Json& json, std::array<T, count>& values, bool) {
    if (!json.is_array() || json.size() != count)
      throw std::invalid_argument(fmt::format("must be a list of {}", count));
    for (std::size_t i = 0; i < count; ++i) JsonReader::read(json[i], values[i], false);
  }
};

template <int rows>
struct Converter<Eigen::Matrix<double, rows, 1>> {
  static Json write(Eigen::Matrix<double, rows, 1>& vector) {
    Json json = Json::array();
    for (double value : vector) json.push_back(number_json(value));
    return json;
  }
  static void read(const Json& json, Eigen::Matrix<double, rows, 1>& vector, bool) {
    if (!json.is_array() || json.size() != static_cast<std::size_t>(rows))
      throw std::invalid_argument(fmt::format("must be a list of {}", rows));
    for (int i = 0; i < rows; ++i) vector[i] = number_of(json[static_cast<std::size_t>(i)]);
  }
};

template <class T>
struct Converter<std::map<std::string, T>> {
  static Json write(std::map<std::string, T>& values) {
    Json json = Json::object();
    for (auto& [name, value] : values) json[name] = JsonWriter::written(value);
    return json;
  }
  static void read(const Json& json, std::map<std::string, T>& values, bool missing_keeps_default) {
    if (!json.is_object()) throw std::invalid_argument("must be an object");
    values.clear();
    for (const auto& [name, value] : json.items())
      JsonReader::read(value, values[name], missing_keeps_default);
  }
};

}  // namespace archive_detail

template <class T>
Json JsonWriter::written(T& value) {
  return archive_detail::Converter<std::remove_const_t<T>>::write(value);
}

template <class T>
void JsonReader::read(const Json& json, T& value, bool missing_keeps_default) {
  archive_detail::Converter<T>::read(json, value, missing_keeps_default);
}

}  // namespace graintruth::datasets
