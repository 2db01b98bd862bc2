#include "app/scenes/hopper_measures.h"

#include <algorithm>
#include <array>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>
#include <map>
#include <utility>

namespace graintruth::app {

namespace {

constexpr std::size_t fewest_places = 3;  // that a line is laid through

using Places = std::vector<std::pair<double, double>>;

// Theil and Sen: the median of the slopes between any two places with different first coordinates.
std::optional<double> robust_slope(const Places& places) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double run = places[i].first - places[j].first;
      if (run != 0.0) slopes.push_back((places[i].second - places[j].second) / run);
    }
  }
  if (slopes.empty()) return std::nullopt;
  return boost::math::statistics::median(slopes);
}

struct Grain {
  double outwards = 0.0;  // m, from the middle
  bool is_slow = false;
};

// The place inside of which the fewest grains are slow and outside of which the fewest are fast;
// the mean of such places where several serve alike. None where all grains are of one kind.
std::optional<double> edge_of_slow(std::vector<Grain> row) {
  std::sort(row.begin(), row.end(), [](const Grain& a, const Grain& b) {
    return a.outwards < b.outwards;
  });
  const auto slow = std::count_if(row.begin(), row.end(), [](const Grain& g) { return g.is_slow; });
  if (slow == 0 || slow == std::ssize(row)) return std::nullopt;
  auto wrong = std::ssize(row) - slow, fewest = wrong + 1;  // with the edge inside of all grains
  double sum = 0.0;
  int places = 0;
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    wrong += row[i].is_slow ? 1 : -1;
    if (wrong > fewest) continue;
    if (wrong < fewest) {
      fewest = wrong;
      sum = 0.0;
      places = 0;
    }
    sum += 0.5 * (row[i].outwards + row[i + 1].outwards);
    ++places;
  }
  return sum / places;
}

std::size_t side_of(double x) { return x < 0.0 ? 0 : 1; }

}  // namespace

std::optional<double> shear_band_angle(std::span<const sim::State> states,
                                       const BandRegion& region) {
  std::array<Places, 2> edges;                          // (height, outwards)
  std::array<std::map<std::size_t, int>, 2> rows_seen;  // how often
  for (const sim::State& state : states) {
    std::array<std::map<std::size_t, std::vector<Grain>>, 2> rows;
    double largest = 0.0;
    const auto is_looked_at = [&](const sim::Vec3& place) {
      return place.z() >= 0.0 && place.z() < region.height;
    };
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      if (is_looked_at(state.position[i])) largest = std::max(largest, state.velocity[i].norm());
    }
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      const sim::Vec3& place = state.position[i];
      if (!is_looked_at(place)) continue;
      const auto row = static_cast<std::size_t>(place.z() / region.row_height);
      rows[side_of(place.x())][row].push_back(
          {std::abs(place.x()), state.velocity[i].norm() < region.slow_share * largest});
    }
    for (std::size_t side = 0; side < rows.size(); ++side) {
      for (const auto& [row, grains] : rows[side]) {
        const auto edge = edge_of_slow(grains);
        if (!edge) continue;
        edges[side].emplace_back((static_cast<double>(row) + 0.5) * region.row_height, *edge);
        ++rows_seen[side][row];
      }
    }
  }
  double sum = 0.0;
  for (std::size_t side = 0; side < edges.size(); ++side) {
    if (rows_seen[side].size() < fewest_places) return std::nullopt;
    sum += std::atan2(1.0, *robust_slope(edges[side]));
  }
  return sum / static_cast<double>(edges.size());
}

std::optional<double> heap_slope(std::span<const sim::Vec3> centres,
                                 double half_width,
                                 double column_width) {
  std::array<std::map<std::size_t, double>, 2> tops;
  for (const sim::Vec3& centre : centres) {
    const double outwards = std::abs(centre.x());
    if (outwards < 0.15 * half_width || outwards > 0.85 * half_width) continue;
    double& top = tops[side_of(centre.x())]
                      .try_emplace(static_cast<std::size_t>(outwards / column_width), centre.z())
                      .first->second;
    top = std::max(top, centre.z());
  }
  double sum = 0.0;
  for (const auto& side : tops) {
    if (side.size() < fewest_places) return std::nullopt;
    Places surface;
    for (const auto& [column, top] : side)
      surface.emplace_back((static_cast<double>(column) + 0.5) * column_width, top);
    sum += std::atan(-*robust_slope(surface));
  }
  return sum / static_cast<double>(tops.size());
}

}  // namespace graintruth::app
