// The numbers that one observable makes of one recording, filmed or simulated alike.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::calibrate {

struct Channel {
  std::vector<double> values;  // NaN where it is not known; empty: the recording cannot tell
  std::vector<double> errors;  // standard deviations of the measurement; empty where none are known
  // What a report wants to know beside them, by name
  std::map<std::string, std::vector<double>> details;

  bool is_known() const { return !values.empty(); }
};

// How two values differ.
enum class Difference {
  plain,     // a - b
  half_turn  // the same modulo pi, in [-pi/2, pi/2): directions of axes
};

// By what a difference of numbers is divided before conditions are pooled.
enum class Relative { absolute, to_mean, to_largest };

// From where the half width of an observable's interval comes.
enum class Widths {
  own_replicates,  // of every value, from its own replicates and those at neighbouring moments
  pooled           // one scatter for all values, pooled over conditions
};

// What the values of a channel are. Values lie moment after moment, within a moment series after
// series.
struct ChannelShape {
  Widths widths = Widths::pooled;
  std::size_t series = 1;  // values of one moment
  // In turn over the series
  std::vector<Difference> difference = {Difference::plain};
  // Own replicates: the smallest error that is believed where none is stated, in turn over series
  std::vector<double> least_error = {0.0};
  // Pooled
  Relative relative = Relative::absolute;
  double resolution = 0.0;  // how finely it can be known at all: a particle, say

  Difference difference_of(std::size_t value) const {
    return difference[value % series % difference.size()];
  }
  double least_error_of(std::size_t value) const {
    return least_error[value % series % least_error.size()];
  }
};

double difference(Difference kind, double a, double b);

}  // namespace graintruth::calibrate
