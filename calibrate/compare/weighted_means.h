// Means of channels over repeats under many weightings, as a jackknife needs them: what does not
// depend on the weights (sines and cosines) is computed once.
#pragma once

#include <span>
#include <vector>

#include "calibrate/observables/channel.h"

namespace graintruth::calibrate {

// One value over repeats.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;  // divisor n - 1; about the circular mean for directions
  int count = 0;                    // repeats in which it is known
};

class WeightedMeans {
 public:
  // The repeats, which all have the same number of values, must outlive it.
  WeightedMeans(std::vector<const Channel*> repeats, const ChannelShape& shape);

  std::size_t repeats() const { return repeats_.size(); }
  // `weights` counts how often each repeat enters. NaN where none of those knows a value.
  std::vector<double> mean(std::span<const int> weights) const;
  std::vector<double> mean() const;

 private:
  struct Direction {
    double sine, cosine;  // of twice the angle
  };
  std::vector<const Channel*> repeats_;
  const ChannelShape* shape_;
  std::vector<std::vector<Direction>> directions_;  // of every value of every repeat that is one
};

// Mean and spread of every value.
std::vector<Spread> spreads_of(std::span<const Channel* const> repeats, const ChannelShape& shape);

// Addresses of all.
std::vector<const Channel*> pointers_to(std::span<const Channel> channels);

}  // namespace graintruth::calibrate
