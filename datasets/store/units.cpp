#include "datasets/store/units.h"

#include <fmt/format.h>

#include <cmath>

namespace graintruth::datasets {

std::optional<std::string> complaint_about(double written, double in_si, const Range& range) {
  const bool too_low = range.includes_lower ? in_si < range.lower : in_si <= range.lower;
  if (std::isfinite(in_si) && !too_low && in_si <= range.upper) return std::nullopt;
  return fmt::format("is {}, but {} is needed", written, range.words);
}

}  // namespace graintruth::datasets
