#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

#define KIND(name) extern const RigKind name;
#include "datasets/rigs/kinds.def"
#undef KIND

namespace {

constexpr std::array all = {
#define KIND(name) &(name),
#include "datasets/rigs/kinds.def"
#undef KIND
};

}  // namespace

std::span<const RigKind* const> rig_kinds() { return all; }

const RigKind& rig_kind_named(TomlSection& rig) {
  const std::string name = rig.text("kind");
  std::vector<std::string_view> names;
  for (const RigKind* kind : all) {
    if (kind->name == name) return *kind;
    names.push_back(kind->name);
  }
  rig.fail("kind",
           fmt::format("is '{}', but must be '{}' or '{}'",
                       name,
                       fmt::join(names.begin(), names.end() - 1, "', '"),
                       names.back()));
}

bool RigSection::states(TomlSection& section, std::string_view stem, Units units) const {
  bool states = false;
  for (const Unit& unit : units) states |= section.has(fmt::format("{}_{}", stem, unit.suffix));
  return states;
}

std::optional<double> RigSection::setting(std::string_view stem,
                                          Units units,
                                          const Range& range,
                                          Rig& rig) {
  std::optional<double> value = rig_.optional_quantity(stem, units, range);
  if (replicate_ && states(*replicate_, stem, units)) {
    value = replicate_->quantity(stem, units, range);
  } else if (replicate_ && !value) {
    replicate_->fail(fmt::format("{}_{}", stem, units.back().suffix),
                     "is missing; give it here or once in [rig]");
  }
  if (value) rig.settings.push_back({std::string(stem), *value, units.front().suffix});
  return value;
}

void RigSection::fail(std::string_view stem, Units units, std::string_view complaint) {
  TomlSection& section = replicate_ && states(*replicate_, stem, units) ? *replicate_ : rig_;
  for (const Unit& unit : units) {
    const std::string key = fmt::format("{}_{}", stem, unit.suffix);
    if (section.has(key)) section.fail(key, complaint);
  }
  section.fail(fmt::format("{}_{}", stem, units.front().suffix), complaint);
}

void require_passage(RigSection& section,
                     std::string_view stem,
                     double width,
                     const Particle& particle,
                     Passage passage) {
  const double narrowest = narrowest_width(particle, passage);
  if (width > narrowest) return;
  section.fail(
      stem,
      length_units,
      fmt::format("is {:.4g} mm, but a particle is {:.4g} mm wide where it is narrowest, so "
                  "none gets through",
                  1e3 * width,
                  1e3 * narrowest));
}

Rig read_rig(TomlSection section, TomlSection* replicate, const RigContext& context) {
  const RigKind& kind = rig_kind_named(section);
  Rig rig{.kind = std::string(kind.name), .brings_grains = kind.brings_grains};
  const bool is_one_layer = kind.is_one_layer && !kind.brings_grains;
  rig.front_back_gap =
      is_one_layer
          ? section.quantity("front_back_gap", length_units, positive)
          : section.optional_quantity("front_back_gap", length_units, positive).value_or(0.0);
  if (!kind.brings_grains) {
    rig.gravity = section.optional_quantity("gravity", acceleration_units, positive).value_or(9.81);
    rig.scene.gravity = {0.0, 0.0, -rig.gravity};
    rig.scene.is_planar = is_one_layer;
  }
  RigSection both(section, replicate);
  kind.read(both, context, rig);
  section.finish();
  return rig;
}

std::vector<SeenOutline::Surface> surfaces_of(const SeenOutline& seen) {
  if (!seen.surfaces.empty()) return seen.surfaces;
  return {{.name = "", .from_x = seen.from_x, .to_x = seen.to_x, .floor_z = seen.floor_z}};
}

std::optional<SeenOutline::Surface> surface_named(const SeenOutline& seen, std::string_view name) {
  for (SeenOutline::Surface& surface : surfaces_of(seen))
    if (surface.name == name) return surface;
  return std::nullopt;
}

std::vector<double> outline_columns(const SeenOutline& seen, double grain_diameter) {
  return outline_columns(SeenOutline::Surface{.name = "", .from_x = seen.from_x, .to_x = seen.to_x},
                         grain_diameter);
}

std::vector<double> outline_columns(const SeenOutline::Surface& seen, double grain_diameter) {
  const double width = 0.5 * grain_diameter;
  const auto first = static_cast<long>(std::floor(seen.from_x / width));
  const auto last = static_cast<long>(std::ceil(seen.to_x / width));
  std::vector<double> columns;
  for (long i = first; i < last; ++i) columns.push_back((static_cast<double>(i) + 0.5) * width);
  return columns;
}

// Lengths in mm, speeds in mm/s, turning in rpm, everything else in SI.
std::string words_on(const std::vector<RigSetting>& settings) {
  std::string words;
  for (const auto& [name, value, unit] : settings) {
    std::string title = name;
    std::replace(title.begin(), title.end(), '_', ' ');
    if (!words.empty()) words += ", ";
    if (unit == "m" || unit == "m_per_s") {
      words += fmt::format("{} {:.4g} {}", title, 1e3 * value, unit == "m" ? "mm" : "mm/s");
    } else if (unit == "rad_per_s") {
      words += fmt::format("{} {:.4g} rpm", title, value / (6.0 * radians_per_degree));
    } else {
      words += fmt::format("{} {:.4g} {}", title, value, unit);
    }
  }
  return words;
}

}  // namespace graintruth::datasets
