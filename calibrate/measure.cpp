#include "calibrate/measure.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double pi = std::numbers::pi;

// Mean of values that come one by one, each with a weight.
class PlainMean {
 public:
  void add(double value, int weight) {
    sum_ += weight * value;
    count_ += weight;
  }
  double value() const { return sum_ / count_; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

// Mean direction of axes: half the direction of sum exp(2 i angle); given on the branch next to the
// first value, so that mean tracks stay continuous where the tracks are.
class AxialMean {
 public:
  void add(double angle, double sine, double cosine, int weight) {
    if (std::isnan(reference_)) reference_ = angle;
    sine_ += weight * sine;
    cosine_ += weight * cosine;
  }
  double value() const {
    const double mean = 0.5 * std::atan2(sine_, cosine_);
    return reference_ + difference(Quantity::angle, mean, reference_);
  }

 private:
  double reference_ = nan;
  double sine_ = 0.0;
  double cosine_ = 0.0;
};

double mean_of(Quantity quantity, std::span<const double> values) {
  PlainMean plain;
  AxialMean axial;
  for (const double value : values) {
    if (quantity == Quantity::angle) {
      axial.add(value, std::sin(2.0 * value), std::cos(2.0 * value), 1);
    } else {
      plain.add(value, 1);
    }
  }
  return quantity == Quantity::angle ? axial.value() : plain.value();
}

Spread spread_of(Quantity quantity, std::span<const double> values) {
  Spread spread{.mean = nan, .standard_deviation = nan, .count = static_cast<int>(values.size())};
  if (spread.count == 0) return spread;
  spread.mean = mean_of(quantity, values);
  if (spread.count < 2) return spread;
  double squares = 0.0;
  for (const double value : values) {
    const double deviation = difference(quantity, value, spread.mean);
    squares += deviation * deviation;
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

const char* name_of(Quantity quantity) {
  constexpr std::array<const char*, 3> names = {"x", "z", "angle"};
  return names[static_cast<std::size_t>(quantity)];
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

datasets::Trajectories compared_part(datasets::Trajectories tracks, datasets::Compared compared) {
  if (compared == datasets::Compared::particles) return tracks;
  datasets::Trajectories heap =
      datasets::make_trajectories(tracks.frames(), 1, !tracks.sigmas.empty());
  heap.time = tracks.time;
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
         ++particle) {
      const std::size_t i = tracks.index(frame, particle);
      if (!(tracks.poses[i].z > heap.poses[frame].z) && std::isfinite(heap.poses[frame].z))
        continue;
      heap.poses[frame].z = tracks.poses[i].z;
      if (tracks.sigmas.empty()) continue;
      heap.sigmas[frame].z = tracks.sigmas[i].z;
      heap.scores[frame] = tracks.scores[i];
    }
  }
  return heap;
}

Band measure(std::span<const datasets::Trajectories> repeats) {
  Band band;
  if (repeats.empty()) return band;
  band.time = repeats.front().time;
  band.particles = repeats.front().particles;
  band.spreads.resize(repeats.front().poses.size());
  std::vector<double> seen;
  for (std::size_t i = 0; i < band.spreads.size(); ++i) {
    for (const Quantity quantity : quantities) {
      seen.clear();
      for (const datasets::Trajectories& repeat : repeats) {
        const double value = value_of(repeat.poses[i], quantity);
        if (std::isfinite(value)) seen.push_back(value);
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

WeightedMeans::WeightedMeans(std::span<const datasets::Trajectories> repeats) : repeats_(repeats) {
  for (const datasets::Trajectories& repeat : repeats) {
    directions_.emplace_back();
    for (const datasets::Pose& pose : repeat.poses)
      directions_.back().push_back({std::sin(2.0 * pose.angle), std::cos(2.0 * pose.angle)});
  }
}

datasets::Trajectories WeightedMeans::mean(std::span<const int> weights) const {
  if (repeats_.empty()) return {};
  const datasets::Trajectories& first = repeats_.front();
  datasets::Trajectories mean = datasets::make_trajectories(first.frames(), first.particles, false);
  mean.time = first.time;
  for (std::size_t i = 0; i < mean.poses.size(); ++i) {
    PlainMean x, z;
    AxialMean angle;
    for (std::size_t r = 0; r < repeats_.size(); ++r) {
      if (weights[r] == 0) continue;
      const datasets::Pose& pose = repeats_[r].poses[i];
      if (std::isfinite(pose.x)) x.add(pose.x, weights[r]);
      if (std::isfinite(pose.z)) z.add(pose.z, weights[r]);
      const auto [sine, cosine] = directions_[r][i];
      if (std::isfinite(pose.angle)) angle.add(pose.angle, sine, cosine, weights[r]);
    }
    mean.poses[i] = {x.value(), z.value(), angle.value()};
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
