#include "calibrate/compare/weighted_means.h"

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

// Mean direction of axes (Fisher 1993): half the direction of sum exp(2 i angle); given on the
// branch next to the first value, so that mean tracks stay continuous where the tracks are.
class AxialMean {
 public:
  void add(double angle, double sine, double cosine, int weight) {
    if (std::isnan(reference_)) reference_ = angle;
    sine_ += weight * sine;
    cosine_ += weight * cosine;
  }
  double value() const {
    const double mean = 0.5 * std::atan2(sine_, cosine_);
    return reference_ + difference(Difference::half_turn, mean, reference_);
  }

 private:
  double reference_ = nan;
  double sine_ = 0.0;
  double cosine_ = 0.0;
};

double mean_of(Difference kind, std::span<const double> values) {
  PlainMean plain;
  AxialMean axial;
  for (const double value : values) {
    if (kind == Difference::half_turn) {
      axial.add(value, std::sin(2.0 * value), std::cos(2.0 * value), 1);
    } else {
      plain.add(value, 1);
    }
  }
  return kind == Difference::half_turn ? axial.value() : plain.value();
}

Spread spread_of(Difference kind, std::span<const double> values) {
  Spread spread{.mean = nan, .standard_deviation = nan, .count = static_cast<int>(values.size())};
  if (spread.count == 0) return spread;
  spread.mean = mean_of(kind, values);
  if (spread.count < 2) return spread;
  double squares = 0.0;
  for (const double value : values) {
    const double deviation = difference(kind, value, spread.mean);
    squares += deviation * deviation;
  }
  spread.standard_deviation = std::sqrt(squares / (spread.count - 1));
  return spread;
}

}  // namespace

double difference(Difference kind, double a, double b) {
  const double plain = a - b;
  return kind == Difference::half_turn ? plain - pi * std::floor(plain / pi + 0.5) : plain;
}

std::vector<const Channel*> pointers_to(std::span<const Channel> channels) {
  std::vector<const Channel*> pointers;
  for (const Channel& channel : channels) pointers.push_back(&channel);
  return pointers;
}

WeightedMeans::WeightedMeans(std::vector<const Channel*> repeats, const ChannelShape& shape)
    : repeats_(std::move(repeats)), shape_(&shape) {
  for (const Channel* repeat : repeats_) {
    std::vector<Direction>& directions = directions_.emplace_back();
    for (std::size_t i = 0; i < repeat->values.size(); ++i) {
      if (shape.difference_of(i) != Difference::half_turn) continue;
      const double angle = repeat->values[i];
      directions.push_back({std::sin(2.0 * angle), std::cos(2.0 * angle)});
    }
  }
}

std::vector<double> WeightedMeans::mean(std::span<const int> weights) const {
  if (repeats_.empty()) return {};
  std::vector<double> means(repeats_.front()->values.size());
  std::size_t direction = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const bool is_direction = shape_->difference_of(i) == Difference::half_turn;
    PlainMean plain;
    AxialMean axial;
    for (std::size_t r = 0; r < repeats_.size(); ++r) {
      const double value = repeats_[r]->values[i];
      if (weights[r] == 0 || !std::isfinite(value)) continue;
      if (is_direction) {
        const auto [sine, cosine] = directions_[r][direction];
        axial.add(value, sine, cosine, weights[r]);
      } else {
        plain.add(value, weights[r]);
      }
    }
    means[i] = is_direction ? axial.value() : plain.value();
    direction += is_direction ? 1 : 0;
  }
  return means;
}

std::vector<double> WeightedMeans::mean() const {
  return mean(std::vector<int>(repeats_.size(), 1));
}

std::vector<Spread> spreads_of(std::span<const Channel* const> repeats, const ChannelShape& shape) {
  std::vector<Spread> spreads;
  if (repeats.empty()) return spreads;
  std::vector<double> known;
  for (std::size_t i = 0; i < repeats.front()->values.size(); ++i) {
    known.clear();
    for (const Channel* repeat : repeats) {
      if (std::isfinite(repeat->values[i])) known.push_back(repeat->values[i]);
    }
    spreads.push_back(spread_of(shape.difference_of(i), known));
  }
  return spreads;
}

}  // namespace graintruth::calibrate
