#include "datasets/store/plausible.h"

#include <fmt/format.h>

namespace graintruth::datasets {

namespace {

std::optional<std::string> doubt(double density,
                                 double lowest,
                                 std::string_view words,
                                 std::string_view of_what) {
  if (density >= lowest && density <= densest_solid) return std::nullopt;
  return fmt::format(
      "{}, {:.4g} kg/m3, is {} than {:.0f} kg/m3, which {} have at {}; look at the "
      "units (1 g/cm3 is 1000 kg/m3)",
      words,
      density,
      density < lowest ? "less" : "more",
      density < lowest ? lowest : densest_solid,
      of_what,
      density < lowest ? "least" : "most");
}

}  // namespace

std::optional<std::string> doubt_about_solid(double density, std::string_view words) {
  return doubt(density, lightest_solid, words, "solids");
}

std::optional<std::string> doubt_about_bed(double density, std::string_view words) {
  return doubt(density, loosest_bed * lightest_solid, words, "beds of solid grains");
}

}  // namespace graintruth::datasets
