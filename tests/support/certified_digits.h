// How well a number agrees with a certified one.
#pragma once

#include <algorithm>
#include <cmath>

namespace graintruth::tests {

// Digits that agree, at most 11, as many as NIST states (its log relative error).
inline double digits(double value, double certified) {
  if (value == certified) return 11.0;
  if (!std::isfinite(value)) return 0.0;
  return std::clamp(-std::log10(std::abs(value - certified) / std::abs(certified)), 0.0, 11.0);
}

}  // namespace graintruth::tests
