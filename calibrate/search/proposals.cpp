#include "calibrate/search/proposals.h"

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <numeric>

namespace graintruth::calibrate {

namespace {

constexpr int everywhere = 512;                                // candidates over the whole cube
constexpr std::array<double, 3> scales = {0.15, 0.05, 0.015};  // of each range, around a centre
constexpr int at_each_scale = 96;
constexpr std::size_t closer_look = 160;  // of the candidates
constexpr double apart = 0.05;            // of a range; half of them are as far from one another
constexpr double crowd_reach = 0.03;      // of the range along which most changes
constexpr int draws = 12;

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

double total_at(const Aim& aim, const UnitPoint& place, double objective) {
  return objective + (aim.known ? aim.known(place) : 0.0);
}

// The candidates of lowest predicted total, and these totals: half of them the lowest of all, half
// the lowest that are apart from each other, because a valley that has been seen is full of low
// predictions.
std::vector<double> keep_lowest(const Emulator& emulator,
                                const Aim& aim,
                                std::vector<UnitPoint>& candidates) {
  std::vector<double> totals = emulator.objectives(candidates);
  for (std::size_t i = 0; i < totals.size(); ++i)
    totals[i] = total_at(aim, candidates[i], totals[i]);
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(
      order.begin(), order.end(), [&](auto a, auto b) { return totals[a] < totals[b]; });
  std::vector<UnitPoint> places;
  std::vector<double> kept;
  std::erase_if(order, [&](std::size_t i) {
    return emulator.evaluations_near(candidates[i], crowd_reach) >= aim.crowd;
  });
  const auto keep = [&](std::size_t i) {
    places.push_back(candidates[i]);
    kept.push_back(totals[i]);
  };
  const std::size_t lowest = std::min(order.size(), closer_look / 2);
  for (std::size_t rank = 0; rank < lowest; ++rank) keep(order[rank]);
  for (std::size_t rank = lowest; rank < order.size() && places.size() < closer_look; ++rank) {
    const UnitPoint& candidate = candidates[order[rank]];
    const bool is_apart = std::none_of(places.begin(), places.end(), [&](const UnitPoint& other) {
      return chebyshev_distance(candidate, other) < apart;
    });
    if (is_apart) keep(order[rank]);
  }
  candidates = std::move(places);
  return kept;
}

}  // namespace

std::vector<UnitPoint> propose(const Emulator& emulator,
                               const Aim& aim,
                               const std::vector<UnitPoint>& centres,
                               int count,
                               std::uint64_t seed) {
  std::vector<UnitPoint> candidates = candidates_around(centres, seed);
  const std::vector<double> predicted = keep_lowest(emulator, aim, candidates);
  const auto logarithm = [&](double total) { return std::log(total + aim.floor); };

  std::vector<UnitPoint> chosen;
  std::vector<char> is_taken(candidates.size(), 0);
  Emulator current = emulator;
  double lowest = logarithm(aim.lowest);
  while (static_cast<int>(chosen.size()) < count && chosen.size() < candidates.size()) {
    // E[max(0, ln lowest - ln total)] over draws of what is predicted; where no draw improves, the
    // lowest prediction
    const auto drawn = current.draw_objectives(candidates, draws, seed);
    std::size_t best = candidates.size();
    double most = 0.0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (is_taken[i]) continue;
      double gain = 0.0;
      for (const std::vector<double>& objectives : drawn)
        gain += std::max(0.0, lowest - logarithm(total_at(aim, candidates[i], objectives[i])));
      if (best < candidates.size() && !(gain > most)) continue;
      best = i;
      most = gain;
    }
    is_taken[best] = 1;
    chosen.push_back(candidates[best]);
    lowest = std::min(lowest, logarithm(predicted[best]));
    if (static_cast<int>(chosen.size()) < count) current = current.believing(chosen.back());
  }
  return chosen;
}

}  // namespace graintruth::calibrate
