#include "calibrate/observables/steady_surface.h"

#include <cmath>
#include <limits>
#include <span>

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t fewest_moments = 20;
constexpr double seen_most = 0.9;        // of the moments
constexpr double middle_half = 0.5;      // of the width, of the slope
constexpr double standard_errors = 3.0;  // by which halves differ that drift

struct Moments {
  double mean = 0.0, sd = 0.0;
};

Moments moments_of(std::span<const double> values) {
  Moments made;
  for (const double value : values) made.mean += value / static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) squares += (value - made.mean) * (value - made.mean);
  made.sd = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return made;
}

// In moments.
double correlation_length(std::span<const double> values) {
  const Moments moments = moments_of(values);
  const auto n = static_cast<double>(values.size());
  double length = 1.0;
  for (std::size_t k = 1; 2 * k < values.size(); ++k) {
    double product = 0.0;
    for (std::size_t i = 0; i + k < values.size(); ++i)
      product += (values[i] - moments.mean) * (values[i + k] - moments.mean);
    const double rho = product / (n * moments.sd * moments.sd);
    if (!(rho > 0.0)) break;
    length += 2.0 * rho;
  }
  return length;
}

double standard_error(std::span<const double> values) {
  return moments_of(values).sd *
         std::sqrt(correlation_length(values) / static_cast<double>(values.size()));
}

// The angle of a line through the middle half of the width; NaN where less than half of that is
// seen.
double slope_of(const BedProfile& profile, double width) {
  double n = 0.0, hidden = 0.0, x_sum = 0.0, z_sum = 0.0, xx = 0.0, xz = 0.0;
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    if (std::abs(profile.x[i]) > 0.5 * middle_half * width) continue;
    if (std::isnan(profile.z[i])) {
      hidden += 1.0;
      continue;
    }
    n += 1.0;
    x_sum += profile.x[i];
    z_sum += profile.z[i];
    xx += profile.x[i] * profile.x[i];
    xz += profile.x[i] * profile.z[i];
  }
  if (n < 2.0 || n < hidden) return nan;
  return std::atan((n * xz - x_sum * z_sum) / (n * xx - x_sum * x_sum));
}

// d for which sd / sqrt(n - d) of what is left is smallest.
std::size_t steady_from(std::span<const double> values) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t d = 0; 2 * d <= values.size(); ++d) {
    const std::span<const double> left = values.subspan(d);
    const double error = moments_of(left).sd / std::sqrt(static_cast<double>(left.size()));
    if (error < least) {
      least = error;
      best = d;
    }
  }
  return best;
}

bool drifts(std::span<const double> values) {
  const std::span<const double> early = values.first(values.size() / 2);
  const std::span<const double> late = values.last(values.size() / 2);
  return std::abs(moments_of(early).mean - moments_of(late).mean) >
         standard_errors * std::hypot(standard_error(early), standard_error(late));
}

}  // namespace

std::optional<SteadySurface> steady_surface(const datasets::Outline& outline,
                                            const Situation& situation) {
  // 1. The slope in time
  std::vector<BedProfile> profiles;
  std::vector<double> slopes;
  std::vector<std::size_t> moments;
  for (std::size_t moment = 0; moment < outline.time.size(); ++moment) {
    BedProfile profile = profile_at(outline, moment, situation);
    const double slope = slope_of(profile, first_width(situation));
    if (std::isnan(slope)) continue;
    profiles.push_back(std::move(profile));
    slopes.push_back(slope);
    moments.push_back(moment);
  }
  if (slopes.size() < fewest_moments) return std::nullopt;
  // 2. From where on it is steady
  SteadySurface surface;
  const std::size_t left_out = steady_from(slopes);
  const std::span<const double> steady = std::span<const double>(slopes).subspan(left_out);
  surface.first = moments[left_out];
  surface.moments = steady.size();
  surface.is_drifting = 2 * (left_out + 1) >= slopes.size() && drifts(steady);
  const Moments slope = moments_of(steady);
  const double length = correlation_length(steady);
  surface.slope = slope.mean;
  surface.slope_sd = slope.sd;
  surface.slope_error = standard_error(steady);
  surface.independent = static_cast<double>(steady.size()) / length;
  surface.correlation_time = length * (outline.time.back() - outline.time[surface.first]) /
                             static_cast<double>(steady.size() - 1);
  // 3. Mean and spread of every column
  surface.x = profiles.front().x;
  for (std::size_t i = 0; i < surface.x.size(); ++i) {
    std::vector<double> heights;
    for (std::size_t k = left_out; k < profiles.size(); ++k)
      if (std::isfinite(profiles[k].z[i])) heights.push_back(profiles[k].z[i]);
    const bool is_seen =
        static_cast<double>(heights.size()) >= seen_most * static_cast<double>(steady.size());
    const Moments of_column = is_seen ? moments_of(heights) : Moments{nan, nan};
    surface.mean.push_back(of_column.mean);
    surface.sd.push_back(of_column.sd);
  }
  return surface;
}

}  // namespace graintruth::calibrate
