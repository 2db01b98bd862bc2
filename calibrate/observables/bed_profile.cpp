#include "calibrate/observables/bed_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/repeated_rule.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using datasets::Outline;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double lowest_share = 0.2, highest_share = 0.8;  // of the height, of a flank
constexpr double low_edge = 1.5;                           // grain diameters
constexpr int fewest_columns = 3;

// Mean of the finite heights of the outline's columns from `first` to `last`, and its uncertainty.
void average(const Outline& outline,
             std::size_t moment,
             std::size_t first,
             std::size_t last,
             double& z,
             double& sigma) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t at = outline.index(moment, i);
    if (!std::isfinite(outline.height[at])) continue;
    sum += outline.height[at];
    if (!outline.sigma.empty()) squares += outline.sigma[at] * outline.sigma[at];
    ++count;
  }
  if (count == 0) return;
  z = sum / count;
  if (!outline.sigma.empty()) sigma = std::sqrt(squares) / count;
}

// By a straight line between the columns on both sides of x.
void between(const Outline& outline, std::size_t moment, double x, double& z, double& sigma) {
  const std::vector<double>& own = outline.column;
  const auto after = std::upper_bound(own.begin(), own.end(), x);
  if (after == own.begin() || after == own.end()) return;
  const auto right = static_cast<std::size_t>(after - own.begin());
  const double share = (x - own[right - 1]) / (own[right] - own[right - 1]);
  const std::size_t a = outline.index(moment, right - 1), b = outline.index(moment, right);
  z = outline.height[a] + share * (outline.height[b] - outline.height[a]);
  if (!outline.sigma.empty()) sigma = std::max(outline.sigma[a], outline.sigma[b]);
}

// What is not seen is floor, or hidden.
void tell_floor(double floor, double grain, BedProfile& profile) {
  const std::size_t count = profile.z.size();
  for (std::size_t first = 0; first < count; ++first) {
    if (std::isfinite(profile.z[first])) continue;
    std::size_t after = first;
    while (after < count && !std::isfinite(profile.z[after])) ++after;
    const auto is_low = [&](std::size_t place) {
      return profile.z[place] <= floor + low_edge * grain;
    };
    if (first == 0 || after == count || is_low(first - 1) || is_low(after))
      std::fill(profile.z.begin() + static_cast<std::ptrdiff_t>(first),
                profile.z.begin() + static_cast<std::ptrdiff_t>(after),
                floor);
    first = after;
  }
}

}  // namespace

datasets::SeenOutline::Surface surface_of(const Situation& situation, std::string_view surface) {
  return *datasets::surface_named(*situation.rig.seen_outline, surface);
}

bool runs_out_below(const Situation& situation, std::string_view surface) {
  const double floor = surface_of(situation, surface).floor_z;
  const auto& all = situation.rig.seen_outline->surfaces;
  return std::any_of(
      all.begin(), all.end(), [&](const auto& other) { return other.floor_z < floor; });
}

std::vector<double> columns_of(const Situation& situation, std::string_view surface) {
  return datasets::outline_columns(surface_of(situation, surface), situation.particle.diameter);
}

BedProfile profile_at(const Outline& outline, std::size_t moment, const Situation& situation) {
  BedProfile profile{.x = columns_of(situation, outline.surface),
                     .z = {},
                     .sigma = {},
                     .floor = surface_of(situation, outline.surface).floor_z};
  const std::vector<double>& own = outline.column;
  const double width = profile.x[1] - profile.x[0];
  const double slack = 1e-6 * width;  // round-off of what is written in files
  const bool is_coarser = own[1] - own[0] > width + slack;
  bool anything = false;
  for (const double x : profile.x) {
    double z = nan, sigma = nan;
    if (is_coarser) {
      between(outline, moment, x, z, sigma);
    } else {
      const auto first = std::lower_bound(own.begin(), own.end(), x - 0.5 * width - slack);
      const auto last = std::lower_bound(first, own.end(), x + 0.5 * width - slack);
      average(outline,
              moment,
              static_cast<std::size_t>(first - own.begin()),
              static_cast<std::size_t>(last - own.begin()),
              z,
              sigma);
    }
    anything = anything || std::isfinite(z);
    profile.z.push_back(z);
    profile.sigma.push_back(sigma);
  }
  // In a drum the shell is below the bed everywhere, and no floor is seen
  if (anything && !situation.rig.seen_outline->drum)
    tell_floor(profile.floor, situation.particle.diameter, profile);
  return profile;
}

std::optional<BedProfile> profile_at_rest(const datasets::Recording& recording,
                                          const Situation& situation,
                                          std::string_view surface) {
  const datasets::Outline* outline = recording.outline_of(surface);
  if (!outline || outline->time.empty() || outline->column.size() < 2) return std::nullopt;
  return profile_at(*outline, outline->time.size() - 1, situation);
}

std::optional<std::size_t> apex_of(const BedProfile& profile) {
  std::optional<std::size_t> apex;
  for (std::size_t i = 0; i < profile.z.size(); ++i) {
    if (std::isfinite(profile.z[i]) && (!apex || profile.z[i] > profile.z[*apex])) apex = i;
  }
  return apex;
}

namespace {

// From `from` on in a direction until the end: columns between 20 and 80 % of the height there, as
// far as they are above 20 %.
std::vector<std::size_t> slope_below(const BedProfile& profile,
                                     std::size_t from,
                                     std::ptrdiff_t direction,
                                     std::ptrdiff_t end) {
  const double height = profile.z[from] - profile.floor;
  std::vector<std::size_t> places;
  for (auto i = static_cast<std::ptrdiff_t>(from); i != end; i += direction) {
    const double z = profile.z[static_cast<std::size_t>(i)] - profile.floor;
    if (z < lowest_share * height) break;
    if (z <= highest_share * height) places.push_back(static_cast<std::size_t>(i));
  }
  return places;
}

//   z = a + b x,   s^2 = sum (z - a - b x)^2 / (n - 2),   var b = s^2 / Sxx
// Columns that see the same grain err alike: with k of them a grain, var b is k times that.
// `falling` is +1 where the angle counts as one that falls to the right.
std::optional<Flank> line_through(const BedProfile& profile,
                                  const std::vector<std::size_t>& places,
                                  double falling,
                                  const Situation& situation) {
  if (static_cast<int>(places.size()) < fewest_columns) return std::nullopt;
  const auto n = static_cast<double>(places.size());
  double x_mean = 0.0, z_mean = 0.0;
  for (const std::size_t i : places) {
    x_mean += profile.x[i] / n;
    z_mean += profile.z[i] / n;
  }
  double sxx = 0.0, sxz = 0.0;
  for (const std::size_t i : places) {
    sxx += (profile.x[i] - x_mean) * (profile.x[i] - x_mean);
    sxz += (profile.x[i] - x_mean) * (profile.z[i] - z_mean);
  }
  const double slope = sxz / sxx;
  double squares = 0.0;
  for (const std::size_t i : places) {
    const double off = profile.z[i] - z_mean - slope * (profile.x[i] - x_mean);
    squares += off * off;
  }
  const double alike = std::max(1.0, situation.particle.diameter / (profile.x[1] - profile.x[0]));
  const double slope_error = std::sqrt(alike * squares / (n - 2.0) / sxx);
  Flank flank;
  flank.angle = -falling * std::atan(slope);
  flank.standard_error = slope_error / (1.0 + slope * slope);
  flank.roughness = std::sqrt(squares / n);
  flank.from_x = profile.x[places.front()];
  flank.to_x = profile.x[places.back()];
  flank.columns = static_cast<int>(places.size());
  return flank;
}

}  // namespace

std::optional<Flank> flank_of(const BedProfile& profile, Side side, const Situation& situation) {
  const auto apex = apex_of(profile);
  if (!apex) return std::nullopt;
  const bool to_left = side == Side::left;
  const auto count = static_cast<std::ptrdiff_t>(profile.z.size());
  return line_through(profile,
                      slope_below(profile, *apex, to_left ? -1 : 1, to_left ? -1 : count),
                      to_left ? -1.0 : 1.0,
                      situation);
}

std::optional<std::size_t> valley_of(const BedProfile& profile) {
  std::vector<std::size_t> lowest;
  for (std::size_t i = 0; i < profile.z.size(); ++i) {
    if (std::isnan(profile.z[i])) continue;
    if (!lowest.empty() && profile.z[i] < profile.z[lowest.front()]) lowest.clear();
    if (lowest.empty() || profile.z[i] == profile.z[lowest.front()]) lowest.push_back(i);
  }
  if (lowest.empty()) return std::nullopt;
  return lowest[lowest.size() / 2];
}

std::optional<Flank> slope_of(const BedProfile& profile, Side side, const Situation& situation) {
  const auto valley = valley_of(profile);
  if (!valley) return std::nullopt;
  const bool to_left = side == Side::left;
  std::optional<std::size_t> top;
  for (std::size_t i = to_left ? 0 : *valley + 1; i < (to_left ? *valley : profile.z.size()); ++i)
    if (std::isfinite(profile.z[i]) && (!top || profile.z[i] > profile.z[*top])) top = i;
  if (!top) return std::nullopt;
  return line_through(
      profile,
      slope_below(profile, *top, to_left ? 1 : -1, static_cast<std::ptrdiff_t>(*valley)),
      to_left ? 1.0 : -1.0,
      situation);
}

double foot_of(const BedProfile& profile, Side side, const Situation& situation) {
  const auto apex = apex_of(profile);
  if (!apex) return nan;
  const double limit = profile.floor + situation.particle.diameter;
  const double half = 0.5 * (profile.x[1] - profile.x[0]);
  const std::ptrdiff_t outwards = side == Side::left ? -1 : 1;
  const auto count = static_cast<std::ptrdiff_t>(profile.z.size());
  auto i = static_cast<std::ptrdiff_t>(*apex);
  for (; i >= 0 && i < count; i += outwards) {
    const auto at = static_cast<std::size_t>(i);
    if (std::isnan(profile.z[at])) return nan;
    if (profile.z[at] >= limit) continue;
    if (at == *apex) return profile.x[at];
    const auto before = static_cast<std::size_t>(i - outwards);
    const double share = (profile.z[before] - limit) / (profile.z[before] - profile.z[at]);
    return profile.x[before] + share * (profile.x[at] - profile.x[before]);
  }
  // Up to the end of what is looked at
  return profile.x[static_cast<std::size_t>(i - outwards)] + static_cast<double>(outwards) * half;
}

Span first_span(const Situation& situation, std::string_view surface) {
  const datasets::SeenOutline::Surface own = surface_of(situation, surface);
  Span span;
  for (const datasets::SeenOutline::Polygon& polygon : situation.rig.seen_outline->grains_before) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& corner : polygon) lowest = std::min(lowest, corner.y());
    if (lowest < own.floor_z || (own.top_z && lowest > *own.top_z)) continue;
    for (const Eigen::Vector2d& corner : polygon) span.reach(corner.x());
  }
  return span;
}

double first_width(const Situation& situation, std::string_view surface) {
  const datasets::SeenOutline& seen = *situation.rig.seen_outline;
  if (seen.drum) return 2.0 * seen.drum->radius;
  Span span = first_span(situation, surface);
  if (seen.grains_before.empty() && seen.mover && surface.empty()) {
    for (const Eigen::Vector2d& corner : seen.mover->drawing) span.reach(corner.x());
  }
  return span.is_any() ? span.to - span.from : 0.0;
}

std::vector<double> bottom_of(const Situation& situation, std::string_view surface) {
  const datasets::SeenOutline& seen = *situation.rig.seen_outline;
  const double floor = surface_of(situation, surface).floor_z;
  std::vector<double> bottom = columns_of(situation, surface);
  for (double& x : bottom) {
    if (!seen.drum) {
      x = floor;
      continue;
    }
    const double radius = seen.drum->radius;
    const double aside = std::min(std::abs(x - seen.drum->centre.x()), radius);
    x = seen.drum->centre.y() - std::sqrt(radius * radius - aside * aside);
  }
  return bottom;
}

std::unique_ptr<Rule> rule_of_outlines(const RuleParts& parts,
                                       std::string_view observable,
                                       double least_error,
                                       std::vector<double> lacking) {
  auto of = parts.of(observable);
  if (!of) return nullptr;
  const double grain = parts.situations->front().particle.diameter;
  return std::make_unique<RepeatedRule>(
      of->channel,
      ChannelShape{.widths = Widths::own_replicates, .least_error = {least_error * grain}},
      parts.form,
      *parts.layout,
      std::move(of->replicates),
      std::move(lacking));
}

std::string OfSurface::named(std::string words, std::string_view between) const {
  if (!surface_.empty()) words.append(between).append(surface_);
  return words;
}

const datasets::Outline* OfSurface::outline_in(const datasets::Recording& recording) const {
  const datasets::Outline* outline = recording.outline_of(surface_);
  return outline && !outline->time.empty() && outline->column.size() > 1 ? outline : nullptr;
}

std::string OfSurface::lacking_words() const {
  if (surface_.empty()) return lacking_outline;
  return fmt::format("{}, and surface, which says '{}' there", lacking_outline, surface_);
}

void require_surface(const datasets::Experiment& experiment,
                     std::string_view observable,
                     std::string_view surface) {
  if (experiment.rig.seen_outline) {
    if (datasets::surface_named(*experiment.rig.seen_outline, surface)) return;
    std::vector<std::string> names;
    for (const auto& one : experiment.rig.seen_outline->surfaces)
      names.push_back(fmt::format("'{}_{}'", observable, one.name));
    throw datasets::InputError(
        fmt::format("{}: '{}' is compared, but a rig of kind '{}' has several surfaces; say which: "
                    "{}.",
                    experiment.file.string(),
                    observable,
                    experiment.rig.kind,
                    fmt::join(names, " or ")));
  }
  throw datasets::InputError(
      fmt::format("{}: '{}' is compared, but a rig of kind '{}' does not tell where the outline of "
                  "its bed is seen; compare something else.",
                  experiment.file.string(),
                  observable,
                  experiment.rig.kind));
}

}  // namespace graintruth::calibrate
