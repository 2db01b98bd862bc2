// What both comparisons of a calibration with the truth behind its films share.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace graintruth::bench {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

inline Json read_json(const fs::path& file) {
  std::ifstream stream(file);
  return Json::parse(stream);
}

inline void run(const std::string& arguments) {
  const std::string command = fmt::format("'{}' {}", GRAINTRUTH_PROGRAM, arguments);
  fmt::print("$ graintruth {}\n", arguments);
  std::fflush(stdout);
  if (std::system(command.c_str()) != 0) std::exit(1);
}

struct Check {
  std::string name;
  double value;
  std::string rule;
  bool holds;
};

// NaN where the key is absent.
inline double number(const Json& json, const char* key) {
  return json.contains(key) ? json[key].get<double>() : NAN;
}

inline bool holds_inside(const Json& parameter, double value) {
  return number(parameter, "lower") <= value && value <= number(parameter, "upper");
}

// Prints the checks, keeps them in a file, and returns the exit status.
inline int report(const std::vector<Check>& checks, const fs::path& figures) {
  Json kept = Json::array();
  int broken = 0;
  for (const Check& check : checks) {
    fmt::print("{:28} {:8.3f}  {:54} {}\n",
               check.name,
               check.value,
               check.rule,
               check.holds ? "holds" : "DOES NOT HOLD");
    kept.push_back({{"name", check.name},
                    {"value", check.value},
                    {"rule", check.rule},
                    {"holds", check.holds}});
    broken += check.holds ? 0 : 1;
  }
  std::ofstream(figures) << kept.dump(2) << "\n";
  return broken == 0 ? 0 : 1;
}

}  // namespace graintruth::bench
