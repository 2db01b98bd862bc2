// What numbers can be: a density that no solid has was given in another unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace graintruth::datasets {

// kg/m3. From cork and light woods (some 120) and the lightest plastic grains to osmium (22600).
// Foam and aerogel lie below.
inline constexpr double lightest_solid = 100.0, densest_solid = 25000.0;
// A bed of grains is at least this share grain, be they ever so loose.
inline constexpr double loosest_bed = 0.3;

// "the density of a particle, 1.2 kg/m3, is ...", or nothing where a solid may have this density
// (kg/m3), or a bed of grains. `words` come first, as "the density of a particle".
std::optional<std::string> doubt_about_solid(double density, std::string_view words);
std::optional<std::string> doubt_about_bed(double density, std::string_view words);

}  // namespace graintruth::datasets
