#include "calibrate/observables/bed_profile.h"

#include <fmt/format.h>

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

double floor_of(const Situation& situation) { return situation.rig.seen_outline->floor_z; }

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

std::vector<double> columns_of(const Situation& situation) {
  return datasets::outline_columns(*situation.rig.seen_outline, situation.particle.diameter);
}

BedProfile profile_at(const Outline& outline, std::size_t moment, const Situation& situation) {
  BedProfile profile{.x = columns_of(situation)};
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
    tell_floor(floor_of(situation), situation.particle.diameter, profile);
  return profile;
}

std::optional<BedProfile> profile_at_rest(const datasets::Recording& recording,
                                          const Situation& situation) {
  const auto& outline = recording.outline;
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

//   z = a + b x,   s^2 = sum (z - a - b x)^2 / (n - 2),   var b = s^2 / Sxx
// Columns that see the same grain err alike: with k of them a grain, var b is k times that.
std::optional<Flank> flank_of(const BedProfile& profile, Side side, const Situation& situation) {
  const auto apex = apex_of(profile);
  if (!apex) return std::nullopt;
  const double floor = floor_of(situation), height = profile.z[*apex] - floor;
  // 1. The columns of the flank
  std::vector<std::size_t> places;
  const std::ptrdiff_t outwards = side == Side::left ? -1 : 1;
  for (auto i = static_cast<std::ptrdiff_t>(*apex);
       i >= 0 && i < static_cast<std::ptrdiff_t>(profile.z.size());
       i += outwards) {
    const double z = profile.z[static_cast<std::size_t>(i)] - floor;
    if (z < lowest_share * height) break;
    if (z <= highest_share * height) places.push_back(static_cast<std::size_t>(i));
  }
  if (static_cast<int>(places.size()) < fewest_columns) return std::nullopt;
  // 2. The line
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
  flank.angle = -static_cast<double>(outwards) * std::atan(slope);
  flank.standard_error = slope_error / (1.0 + slope * slope);
  flank.roughness = std::sqrt(squares / n);
  flank.from_x = profile.x[places.front()];
  flank.to_x = profile.x[places.back()];
  flank.columns = static_cast<int>(places.size());
  return flank;
}

double foot_of(const BedProfile& profile, Side side, const Situation& situation) {
  const auto apex = apex_of(profile);
  if (!apex) return nan;
  const double limit = floor_of(situation) + situation.particle.diameter;
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

double first_width(const Situation& situation) {
  const datasets::SeenOutline& seen = *situation.rig.seen_outline;
  if (seen.drum) return 2.0 * seen.drum->radius;
  double left = std::numeric_limits<double>::infinity(), right = -left;
  const auto reach = [&](const datasets::SeenOutline::Polygon& polygon) {
    for (const Eigen::Vector2d& corner : polygon) {
      left = std::min(left, corner.x());
      right = std::max(right, corner.x());
    }
  };
  for (const datasets::SeenOutline::Polygon& polygon : seen.grains_before) reach(polygon);
  if (seen.grains_before.empty() && seen.mover) reach(seen.mover->drawing);
  return right > left ? right - left : 0.0;
}

std::vector<double> bottom_of(const Situation& situation) {
  const datasets::SeenOutline& seen = *situation.rig.seen_outline;
  std::vector<double> bottom = columns_of(situation);
  for (double& x : bottom) {
    if (!seen.drum) {
      x = seen.floor_z;
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

void require_outline(const datasets::Experiment& experiment, std::string_view observable) {
  if (experiment.rig.seen_outline) return;
  throw datasets::InputError(
      fmt::format("{}: '{}' is compared, but a rig of kind '{}' does not tell where the outline of "
                  "its bed is seen; compare something else.",
                  experiment.file.string(),
                  observable,
                  experiment.rig.kind));
}

}  // namespace graintruth::calibrate
