#include "sim/shapes/profile.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

// Places on the axis at which a profile is looked at when circles are drawn and fits are judged.
constexpr int kSamples = 2000;
constexpr int kBisections = 60;

double square_of(const ProfilePoint& point) { return point.y * point.y; }

// Slope at the middle one of three points of the parabola through them.
double parabola_slope(const ProfilePoint& a, const ProfilePoint& b, const ProfilePoint& c) {
  const double before = (square_of(b) - square_of(a)) / (b.x - a.x);
  const double after = (square_of(c) - square_of(b)) / (c.x - b.x);
  return (before * (c.x - b.x) + after * (b.x - a.x)) / (c.x - a.x);
}

double distance_squared(const ProfilePoint& a, const ProfilePoint& b) {
  return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
}

// Where a circle about `start` first meets the profile to the right of it; nothing when the profile
// ends inside.
std::optional<ProfilePoint> next_division(const Profile& profile,
                                          const ProfilePoint& start,
                                          double chord) {
  const auto is_inside = [&](double x) {
    return distance_squared(start, {x, profile.half_width(x)}) < chord * chord;
  };
  const double stride = (profile.to() - profile.from()) / kSamples;
  double inside = start.x;
  double outside = start.x;
  do {
    if (outside >= profile.to()) return std::nullopt;
    inside = outside;
    outside = std::min(outside + stride, profile.to());
  } while (is_inside(outside));
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (inside + outside);
    (is_inside(middle) ? inside : outside) = middle;
  }
  return ProfilePoint{outside, profile.half_width(outside)};
}

// The divisions from the left end on, and what is left of the last chord as a share of it; no more
// than one beyond `most`.
struct Divisions {
  std::vector<ProfilePoint> points;
  double chords = 0.0;  // whole ones and the share of the last
};

Divisions divide(const Profile& profile, double chord, int most) {
  Divisions divisions;
  ProfilePoint point{profile.from(), profile.half_width(profile.from())};
  while (divisions.points.size() <= static_cast<std::size_t>(most)) {
    const auto next = next_division(profile, point, chord);
    if (!next) break;
    point = *next;
    divisions.points.push_back(point);
  }
  const ProfilePoint end{profile.to(), profile.half_width(profile.to())};
  divisions.chords = static_cast<double>(divisions.points.size()) +
                     std::sqrt(distance_squared(point, end)) / chord;
  return divisions;
}

double union_half_width(const std::vector<ElementSphere>& spheres, double x) {
  double square = 0.0;
  for (const ElementSphere& sphere : spheres) {
    const double along = x - sphere.centre.x();
    square = std::max(square, sphere.radius * sphere.radius - along * along);
  }
  return std::sqrt(square);
}

}  // namespace

Profile::Profile(std::vector<ProfilePoint> points) : points_(std::move(points)) {
  const std::size_t count = points_.size();
  if (count < 3) throw std::invalid_argument("Profile: at least three points are needed");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = "Profile: point " + std::to_string(i + 1);
    if (!std::isfinite(points_[i].x) || !std::isfinite(points_[i].y)) {
      throw std::invalid_argument(name + " is not finite");
    }
    if (i > 0 && !(points_[i].x > points_[i - 1].x)) {
      throw std::invalid_argument(name + " does not lie to the right of the one before");
    }
    const bool is_end = i == 0 || i + 1 == count;
    if (!(points_[i].y > 0.0 || (is_end && points_[i].y == 0.0))) {
      throw std::invalid_argument(name + " has a half-width that is not above zero");
    }
  }
  slope_.resize(count);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    slope_[i] = parabola_slope(points_[i - 1], points_[i], points_[i + 1]);
  }
  // The same parabolas reach to the ends: slope there = 2 chord slope - slope at the neighbour
  const auto end_slope = [&](std::size_t end, std::size_t neighbour) {
    const double chord = (square_of(points_[neighbour]) - square_of(points_[end])) /
                         (points_[neighbour].x - points_[end].x);
    return 2.0 * chord - slope_[neighbour];
  };
  slope_.front() = end_slope(0, 1);
  slope_.back() = end_slope(count - 1, count - 2);
}

Profile::Value Profile::at(double x) const {
  // 1. The interval
  const auto above = std::upper_bound(
      points_.begin(), points_.end(), x, [](double value, const ProfilePoint& point) {
        return value < point.x;
      });
  const auto last = static_cast<std::ptrdiff_t>(points_.size()) - 2;
  const auto i =
      static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above - points_.begin() - 1, 0, last));
  const double width = points_[i + 1].x - points_[i].x;
  const double a = square_of(points_[i]), b = square_of(points_[i + 1]);
  // 2. Cubic Hermite in t = (x - x_i)/width, and its slope
  const double t = std::clamp((x - points_[i].x) / width, 0.0, 1.0);
  const double u = 1.0 - t;
  const double square = a * u * u * (1.0 + 2.0 * t) + b * t * t * (3.0 - 2.0 * t) +
                        width * t * u * (slope_[i] * u - slope_[i + 1] * t);
  if (square >= 0.0) {
    return {square,
            6.0 * t * u * (b - a) / width + slope_[i] * u * (u - 2.0 * t) +
                slope_[i + 1] * t * (t - 2.0 * u)};
  }
  return {a * u + b * t, (b - a) / width};
}

double Profile::half_width(double x) const { return std::sqrt(at(x).square); }

double Profile::half_square_slope(double x) const { return 0.5 * at(x).slope; }

Profile ellipse_profile(double along, double across) {
  // y^2 is a parabola, which the table holds exactly
  const double half = 0.5 * std::sqrt(3.0) * across;
  return Profile({{-along, 0.0}, {-0.5 * along, half}, {0.5 * along, half}, {along, 0.0}});
}

// At a division the tangent sphere has (thesis 2.3)
//   c = x + y tan(theta) = x + y y',   r = y / cos(theta) = sqrt(y^2 + (y y')^2),  tan(theta) = y'
ProfileFit fit_profile(const Profile& profile, int chords) {
  if (chords < 2) throw std::invalid_argument("fit_profile: at least two chords are needed");
  // 1. The chord length that ends on the profile's end: longer chords, fewer of them
  const double length = profile.to() - profile.from();
  double shorter = 0.5 * length / chords, longer = shorter;
  while (divide(profile, longer, chords).chords > chords) longer *= 1.2;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (shorter + longer);
    (divide(profile, middle, chords).chords > chords ? shorter : longer) = middle;
  }
  ProfileFit fit;
  fit.chord = longer;

  // 2. Spheres at the inner divisions
  Divisions divisions = divide(profile, longer, chords);
  divisions.points.resize(std::min(divisions.points.size(), static_cast<std::size_t>(chords - 1)));
  for (const ProfilePoint& point : divisions.points) {
    const double tilt = profile.half_square_slope(point.x);
    fit.spheres.push_back({Vec3(point.x + tilt, 0.0, 0.0), std::hypot(point.y, tilt)});
  }

  // 3. How well the union fills the profile; beyond its ends all of a sphere is protrusion
  for (int i = 0; i <= kSamples; ++i) {
    const double x = profile.from() + length * i / kSamples;
    const double gap = profile.half_width(x) - union_half_width(fit.spheres, x);
    fit.protrusion = std::max(fit.protrusion, -gap);
    fit.shortfall = std::max(fit.shortfall, gap);
  }
  for (const ElementSphere& sphere : fit.spheres) {
    fit.protrusion = std::max({fit.protrusion,
                               profile.from() - (sphere.centre.x() - sphere.radius),
                               sphere.centre.x() + sphere.radius - profile.to()});
  }
  return fit;
}

std::vector<ElementSphere> chain_of_volume(int count, double aspect_ratio, double volume) {
  const bool is_ball = count == 1 && aspect_ratio == 1.0;
  if (!(volume > 0.0) || !(is_ball || (aspect_ratio > 1.0 && aspect_ratio <= count))) {
    throw std::invalid_argument(
        "chain_of_volume: the volume must be above 0, the aspect ratio above 1 and at most the "
        "number of spheres");
  }
  // length = 2 R + (n - 1) spacing = 2 R A; volume grows with R^3
  const double spacing = is_ball ? 0.0 : 2.0 * (aspect_ratio - 1.0) / (count - 1);
  const double of_unit = mass_properties_of_union(chain_of_spheres(count, 1.0, spacing)).volume;
  const double radius = exact_cbrt(volume / of_unit);
  return chain_of_spheres(count, radius, radius * spacing);
}

}  // namespace graintruth::sim
