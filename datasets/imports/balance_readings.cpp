#include "datasets/imports/balance_readings.h"

#include <algorithm>
#include <array>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>

#include "datasets/statistics/linear_least_squares.h"

namespace graintruth::datasets {

namespace {

constexpr double sigmas_of_a_spike = 8.0;
constexpr double sigma_of_median = 1.4826;  // standard deviation over the median of sizes (Gauss)

double median(std::vector<double> values) { return boost::math::statistics::median(values); }

// The reading less the line through its neighbours, in units in which white noise keeps its size.
double off_neighbours(std::span<const Reading> readings, std::size_t i) {
  const Reading &before = readings[i - 1], &now = readings[i], &after = readings[i + 1];
  const double share = (now.time - before.time) / (after.time - before.time);
  const double miss = now.mass - (1.0 - share) * before.mass - share * after.mass;
  return miss / std::sqrt(1.0 + share * share + (1.0 - share) * (1.0 - share));
}

// The least difference that the balance shows.
double resolution_of(std::span<const Reading> readings) {
  double least = 0.0;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const double step = std::abs(readings[i].mass - readings[i - 1].mass);
    if (step > 0.0 && (least == 0.0 || step < least)) least = step;
  }
  return least;
}

// Of the readings `reach` to either side, or as many as there are on both.
double median_about(std::span<const Reading> readings, std::size_t i, std::size_t reach) {
  reach = std::min({reach, i, readings.size() - 1 - i});
  std::vector<double> window;
  for (std::size_t k = i - reach; k <= i + reach; ++k) window.push_back(readings[k].mass);
  return median(std::move(window));
}

// Share of neighbouring readings at rest that are equal, as far as so few of them tell.
double share_of_equal(std::span<const Reading> at_rest) {
  double equal = 1.0, pairs = 2.0;
  for (std::size_t i = 1; i < at_rest.size(); ++i) {
    pairs += 1.0;
    if (at_rest[i].mass == at_rest[i - 1].mass) equal += 1.0;
  }
  return equal / pairs;
}

// Steps of readings that move, in size: the middle one, and what three of four do not exceed.
struct Steps {
  double middle = 0.0, upper = 0.0;
};
Steps steps_without(std::span<const Reading> readings, std::size_t from, std::size_t left_out) {
  std::vector<double> steps;
  for (std::size_t i = from + 1; i < readings.size(); ++i) {
    const double step = std::abs(readings[i].mass - readings[i - 1].mass);
    if (step > 0.0 && i != left_out) steps.push_back(step);
  }
  if (steps.empty()) return {};
  std::sort(steps.begin(), steps.end());
  return {steps[steps.size() / 2], steps[3 * steps.size() / 4]};
}

}  // namespace

double noise_of(std::span<const Reading> readings) {
  constexpr std::size_t fewest = 12;
  if (readings.size() < fewest) return 0.0;
  std::vector<double> sizes;
  for (std::size_t i = 1; i + 1 < readings.size(); ++i)
    sizes.push_back(std::abs(off_neighbours(readings, i)));
  return sigma_of_median * median(std::move(sizes));
}

std::vector<Spike> find_spikes(std::span<const Reading> readings, double particle_mass) {
  constexpr std::size_t reach = 3;              // readings to either side
  constexpr std::size_t fewest_for_last = 20;   // readings of a curve whose end can be judged
  constexpr std::size_t steps_before_last = 6;  // that say how fast the mass may move
  constexpr double times_as_large = 3.0;
  // A reading that flickers by a unit of the display or two stands out of nothing
  const double limit = std::max(
      {sigmas_of_a_spike * noise_of(readings), particle_mass, 3.0 * resolution_of(readings)});
  std::vector<Spike> spikes;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double off = readings[i].mass - median_about(readings, i, reach);
    if (std::abs(off) > limit) spikes.push_back({i, off});
  }
  if (readings.size() < fewest_for_last) return spikes;
  const std::size_t last = readings.size() - 1;
  double largest = 0.0;
  for (std::size_t k = last - steps_before_last; k < last; ++k)
    largest = std::max(largest, std::abs(readings[k].mass - readings[k - 1].mass));
  const double step = readings[last].mass - readings[last - 1].mass;
  const bool is_after_a_spike = !spikes.empty() && spikes.back().place == last - 1;
  if (!is_after_a_spike && std::abs(step) > limit + times_as_large * largest)
    spikes.push_back({last, step});
  return spikes;
}

std::vector<Stuck> find_stuck(std::span<const Reading> readings,
                              std::size_t rest,
                              double particle_mass) {
  constexpr std::size_t fewest = 5;
  constexpr std::size_t fewest_at_rest = 10;
  constexpr double times_as_large = 6.0, share_made_up = 1.0 / 3.0, once_in = 1e-6;
  const std::span<const Reading> at_rest = readings.first(rest);
  const double equal = share_of_equal(at_rest);
  const double noise = noise_of(readings);
  // Where the display is coarser than the noise, equal readings tell nothing
  const bool is_fine = rest >= fewest_at_rest && noise_of(at_rest) > 2.0 * resolution_of(readings);
  std::vector<Stuck> stuck;
  for (std::size_t first = rest == 0 ? 0 : rest - 1; first < readings.size();) {
    std::size_t last = first;
    while (last + 1 < readings.size() && readings[last + 1].mass == readings[first].mass) ++last;
    const std::size_t length = last - first + 1;
    Stuck run{first, last};
    if (length >= fewest) {
      bool is_stuck = is_fine && std::pow(equal, static_cast<double>(length - 1)) *
                                         static_cast<double>(readings.size()) <
                                     once_in;
      if (last + 1 < readings.size()) {
        run.jump = readings[last + 1].mass - readings[last].mass;
        const double jump = std::abs(run.jump);
        const Steps others = steps_without(readings, rest == 0 ? 0 : rest - 1, last + 1);
        is_stuck |= others.middle > 0.0 && jump > times_as_large * others.upper &&
                    jump > sigmas_of_a_spike * noise && jump > 2.0 * particle_mass &&
                    jump > share_made_up * static_cast<double>(length) * others.middle;
      }
      if (is_stuck) stuck.push_back(run);
    }
    first = last + 1;
  }
  return stuck;
}

double fastest_rate(std::span<const Reading> readings) {
  const std::size_t stretch = std::max<std::size_t>(1, readings.size() / 10);
  double fastest = 0.0;
  for (std::size_t i = 0; i + stretch < readings.size(); ++i) {
    const Reading &from = readings[i], &to = readings[i + stretch];
    fastest = std::max(fastest, std::abs(to.mass - from.mass) / (to.time - from.time));
  }
  return fastest;
}

Tare find_tare(std::span<const Reading> at_rest, double least_drift, double least_flow) {
  constexpr std::size_t parts = 8, fewest = 2 * parts;
  constexpr double one_in_1000 = 5.959;  // Student's t of eight parts less two parameters
  Tare tare;
  if (at_rest.size() >= fewest) {
    std::vector<double> times, levels;
    for (std::size_t part = 0; part < parts; ++part) {
      std::vector<double> time, mass;
      for (std::size_t i = part * at_rest.size() / parts; i < (part + 1) * at_rest.size() / parts;
           ++i) {
        time.push_back(at_rest[i].time);
        mass.push_back(at_rest[i].mass);
      }
      times.push_back(median(std::move(time)));
      levels.push_back(median(std::move(mass)));
    }
    const StraightLine line = straight_line(times, levels);
    const double error = line.slope_standard_error(parts);
    const double speed = std::abs(line.slope);
    if (speed > std::max(one_in_1000 * error, least_drift) && speed < least_flow) {
      tare.drift = line.slope;
      tare.drift_standard_error = error;
    }
  }
  std::vector<double> levels;
  for (const Reading& reading : at_rest) levels.push_back(reading.mass - tare.drift * reading.time);
  tare.level = median(std::move(levels));
  return tare;
}

std::vector<double> never_falling(std::span<const double> values) {
  struct Pool {
    double mean;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (const double value : values) {
    pools.push_back({value, 1});
    while (pools.size() > 1 && pools[pools.size() - 2].mean > pools.back().mean) {
      const Pool last = pools.back();
      pools.pop_back();
      Pool& before = pools.back();
      const auto count = static_cast<double>(before.count), more = static_cast<double>(last.count);
      before.mean = (before.mean * count + last.mean * more) / (count + more);
      before.count += last.count;
    }
  }
  std::vector<double> result;
  for (const Pool& pool : pools) result.insert(result.end(), pool.count, pool.mean);
  return result;
}

}  // namespace graintruth::datasets
