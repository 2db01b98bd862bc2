#include "calibrate/measure.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double pi = std::numbers::pi;

struct Repeat {
  double value;
  int weight;
};

double plain_mean(std::span<const Repeat> repeats) {
  double sum = 0.0;
  int count = 0;
  for (const Repeat& repeat : repeats) {
    sum += repeat.weight * repeat.value;
    count += repeat.weight;
  }
  return sum / count;
}

// Mean direction of axes: half the direction of sum exp(2 i angle); given on the branch next to the
// first value, so that mean tracks stay continuous where the tracks are.
double axial_mean(std::span<const Repeat> repeats) {
  double sine = 0.0;
  double cosine = 0.0;
  for (const Repeat& repeat : repeats) {
    sine += repeat.weight * std::sin(2.0 * repeat.value);
    cosine += repeat.weight * std::cos(2.0 * repeat.value);
  }
  const double mean = 0.5 * std::atan2(sine, cosine);
  const double reference = repeats.front().value;
  return reference + difference(Quantity::angle, mean, reference);
}

Spread spread_of(Quantity quantity, std::span<const Repeat> repeats) {
  Spread spread{.mean = nan, .standard_deviation = nan, .count = 0};
  for (const Repeat& repeat : repeats) spread.count += repeat.weight;
  if (spread.count == 0) return spread;
  spread.mean = quantity == Quantity::angle ? axial_mean(repeats) : plain_mean(repeats);
  if (spread.count < 2) return spread;
  double squares = 0.0;
  for (const Repeat& repeat : repeats) {
    const double deviation = difference(quantity, repeat.value, spread.mean);
    squares += repeat.weight * deviation * deviation;
  }
  spread.standard_deviation = std::sqrt(squares / (spread.count - 1));
  return spread;
}

}  // namespace

double value_of(const datasets::Pose& pose, Quantity quantity) {
  switch (quantity) {
    case Quantity::x:
      return pose.x;
    case Quantity::z:
      return pose.z;
    case Quantity::angle:
      return pose.angle;
  }
  return nan;
}

double difference(Quantity quantity, double a, double b) {
  const double plain = a - b;
  return quantity == Quantity::angle ? plain - pi * std::floor(plain / pi + 0.5) : plain;
}

std::vector<double> measurement_times(double interval, int frames) {
  std::vector<double> times(static_cast<std::size_t>(frames));
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    times[frame] = interval * static_cast<double>(frame);
  }
  return times;
}

Band measure(std::span<const datasets::Trajectories> repeats, std::span<const int> weights) {
  Band band;
  if (repeats.empty()) return band;
  band.time = repeats.front().time;
  band.particles = repeats.front().particles;
  band.spreads.resize(repeats.front().poses.size());
  std::vector<Repeat> seen;
  for (std::size_t i = 0; i < band.spreads.size(); ++i) {
    for (const Quantity quantity : quantities) {
      seen.clear();
      for (std::size_t r = 0; r < repeats.size(); ++r) {
        const double value = value_of(repeats[r].poses[i], quantity);
        const int weight = weights.empty() ? 1 : weights[r];
        if (std::isfinite(value) && weight > 0) seen.push_back({value, weight});
      }
      band.spreads[i][static_cast<std::size_t>(quantity)] = spread_of(quantity, seen);
    }
  }
  return band;
}

datasets::Trajectories mean_track(const Band& band) {
  datasets::Trajectories mean = datasets::make_trajectories(band.frames(), band.particles, false);
  mean.time = band.time;
  for (std::size_t i = 0; i < band.spreads.size(); ++i) {
    mean.poses[i] = {band.spreads[i][0].mean, band.spreads[i][1].mean, band.spreads[i][2].mean};
  }
  return mean;
}

double rms_position(const datasets::Trajectories& a, const datasets::Trajectories& b) {
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    const double dx = a.poses[i].x - b.poses[i].x;
    const double dz = a.poses[i].z - b.poses[i].z;
    const double square = dx * dx + dz * dz;
    if (!std::isfinite(square)) continue;
    squares += square;
    ++count;
  }
  return count == 0 ? nan : std::sqrt(squares / static_cast<double>(count));
}

}  // namespace graintruth::calibrate
