#include "calibrate/proposals.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <optional>

namespace graintruth::calibrate {

namespace {

constexpr int everywhere = 512;                                // candidates over the whole cube
constexpr std::array<double, 3> scales = {0.15, 0.05, 0.015};  // of each range, around a centre
constexpr int at_each_scale = 96;

// E[max(0, lowest - Y)] = (lowest - m) Phi(u) + s phi(u),  u = (lowest - m)/s,  Y ~ N(m, s)
double expected_improvement(const Surrogate::Prediction& prediction, double lowest) {
  const double gain = lowest - prediction.mean;
  const double s = prediction.standard_deviation;
  if (!(s > 0.0)) return std::max(0.0, gain);
  const boost::math::normal_distribution<double> standard;
  return gain * cdf(standard, gain / s) + s * pdf(standard, gain / s);
}

std::vector<UnitPoint> candidates_around(const std::vector<UnitPoint>& centres,
                                         std::uint64_t seed) {
  std::vector<UnitPoint> candidates =
      low_discrepancy_points(everywhere, centres.front().size(), seed);
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal;
  for (const UnitPoint& centre : centres) {
    for (const double scale : scales) {
      for (int i = 0; i < at_each_scale; ++i) {
        candidates.push_back(centre);
        for (double& coordinate : candidates.back())
          coordinate = std::clamp(coordinate + scale * normal(generator), 0.0, 1.0);
      }
    }
  }
  return candidates;
}

}  // namespace

std::vector<UnitPoint> propose(const Surrogate& surrogate,
                               const std::vector<UnitPoint>& centres,
                               int count,
                               std::uint64_t seed) {
  const std::vector<UnitPoint> candidates = candidates_around(centres, seed);
  std::vector<UnitPoint> chosen;
  std::optional<Surrogate> believed;
  while (static_cast<int>(chosen.size()) < count) {
    const Surrogate& current = believed ? *believed : surrogate;
    const double lowest = current.lowest_mean();
    const std::vector<Surrogate::Prediction> predictions = current.predict(candidates);
    const auto best =
        std::max_element(predictions.begin(), predictions.end(), [&](const auto& a, const auto& b) {
          return expected_improvement(a, lowest) < expected_improvement(b, lowest);
        });
    chosen.push_back(candidates[static_cast<std::size_t>(best - predictions.begin())]);
    if (static_cast<int>(chosen.size()) < count) believed.emplace(current.believing(chosen.back()));
  }
  return chosen;
}

}  // namespace graintruth::calibrate
