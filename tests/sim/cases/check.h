// What is verified of the simulator: cases with their source and tolerance. One definition for the
// tests, which ask for PASS, and for the page docs/verification.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace graintruth::sim::cases {

// Short: not what was asked for, but as near to it as is known and said.
enum class Verdict { pass, falls_short, fail, not_run };

// One line of the page. The tolerance is that of the source, the residual the worst one found.
struct Check {
  std::string what;
  std::string source;
  double tolerance = 0.0;
  double residual = 0.0;
  bool at_least = false;    // an order of accuracy: the residual must not be below the tolerance
  bool is_missing = false;  // the reference is not there
  // What is reached where the tolerance is not; NaN: it must hold
  double known_to_reach = std::numeric_limits<double>::quiet_NaN();
  Verdict verdict() const {
    if (is_missing) return Verdict::not_run;
    if (holds(tolerance)) return Verdict::pass;
    return holds(known_to_reach) ? Verdict::falls_short : Verdict::fail;
  }
  bool holds(double bound) const { return at_least ? residual >= bound : residual <= bound; }
};

inline Check within(std::string what, std::string source, double tolerance, double residual) {
  return {std::move(what), std::move(source), tolerance, std::abs(residual)};
}
inline Check order_of(std::string what, std::string source, double least, double order) {
  return {.what = std::move(what),
          .source = std::move(source),
          .tolerance = least,
          .residual = order,
          .at_least = true};
}
inline Check missing(std::string what, std::string source) {
  return {.what = std::move(what), .source = std::move(source), .is_missing = true};
}

// The largest deviation of many; a number that is not finite is the worst of all.
struct Worst {
  double value = 0.0;
  void see(double deviation) {
    if (std::isnan(deviation)) deviation = std::numeric_limits<double>::infinity();
    value = std::max(value, std::abs(deviation));
  }
  void see_ratio(double found, double expected) { see(found / expected - 1.0); }
};

// log2 of how much the error falls when the step is halved.
inline double observed_order(double coarse_error, double fine_error) {
  return std::log2(std::abs(coarse_error) / std::abs(fine_error));
}

// A group of checks that run together. `name` is that of the test; `note` says what a reader of the
// page should know.
struct Case {
  const char* name;
  const char* title;
  std::vector<Check> (*run)();
  const char* note = "";
};

std::span<const Case> impact_cases();
std::span<const Case> friction_cases();
std::span<const Case> rotation_cases();
std::span<const Case> statics_cases();
std::span<const Case> particle_cases();
std::span<const Case> conservation_cases();
std::span<const Case> mesh_cases();
std::span<const Case> order_cases();

// Of minutes, for the page alone.
std::span<const Case> long_cases();

// All others, in the order of the page.
std::vector<Case> all_cases();

}  // namespace graintruth::sim::cases
