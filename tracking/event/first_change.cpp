#include "tracking/event/first_change.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace graintruth::tracking {

namespace {

constexpr std::size_t fewest_at_rest = 5;
constexpr std::size_t pictures_in_a_row = 3;
constexpr double chance = 1.0e-6;       // that rest looks like motion, at each picture
constexpr double least_share = 0.05;    // of the largest change
constexpr double least_scatter = 0.02;  // of the usual change: codecs level rest out
// The median deviation times the first is the standard deviation of Gaussian noise, and tells it as
// badly as the second part of so many values would (Rousseeuw and Croux 1993).
constexpr double per_median_deviation = 1.4826, efficiency = 0.37;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<FirstChange> find_first_change(const std::vector<double>& changes) {
  if (changes.empty()) return std::nullopt;
  const double largest = *std::max_element(changes.begin(), changes.end());
  for (std::size_t k = fewest_at_rest; k + pictures_in_a_row <= changes.size(); ++k) {
    const auto next = changes.begin() + static_cast<std::ptrdiff_t>(k);
    std::vector<double> rest(changes.begin(), next);
    const double usual = median(rest);
    for (double& value : rest) value = std::abs(value - usual);
    const double scatter =
        std::max({per_median_deviation * median(rest), least_scatter * usual, 1.0e-9});
    const auto n = static_cast<double>(k);
    const boost::math::students_t known_so_well(std::max(1.0, efficiency * (n - 1.0)));
    const double limit =
        std::sqrt(1.0 + 1.0 / n) * boost::math::quantile(boost::math::complement(
                                       known_so_well, std::pow(chance, 1.0 / pictures_in_a_row)));
    const double certainty = (*std::min_element(next, next + pictures_in_a_row) - usual) / scatter;
    // What a codec stores anew is a small part of what motion changes in the end
    if (certainty > std::max(limit, least_share * (largest - usual) / scatter))
      return FirstChange{static_cast<int>(k) + 1, certainty};
  }
  return std::nullopt;
}

}  // namespace graintruth::tracking
