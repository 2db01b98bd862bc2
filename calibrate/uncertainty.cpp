#include "calibrate/uncertainty.h"

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>

namespace graintruth::calibrate {

namespace {

using Generator = boost::random::mt19937_64;

// How often each of n things is drawn in n draws with replacement.
std::vector<int> draw_weights(std::size_t n, Generator& generator) {
  boost::random::uniform_int_distribution<std::size_t> which(0, n - 1);
  std::vector<int> weights(n, 0);
  for (std::size_t i = 0; i < n; ++i) ++weights[which(generator)];
  return weights;
}

bool spread_over_two(const std::vector<int>& weights) {
  return std::count_if(weights.begin(), weights.end(), [](int weight) { return weight > 0; }) > 1;
}

// A regular grid over the unit cube, fine enough that its spacing is small against any interval
// that matters.
std::vector<UnitPoint> grid(std::size_t dimension) {
  const int side = dimension == 1 ? 401 : dimension == 2 ? 71 : 25;
  std::vector<UnitPoint> places = {UnitPoint{}};
  for (std::size_t d = 0; d < dimension; ++d) {
    std::vector<UnitPoint> longer;
    for (const UnitPoint& place : places) {
      for (int i = 0; i < side; ++i) {
        longer.push_back(place);
        longer.back().push_back(static_cast<double>(i) / (side - 1));
      }
    }
    places = std::move(longer);
  }
  return places;
}

std::size_t lowest(std::span<const double> weights,
                   std::span<const double> values,
                   std::size_t places) {
  std::size_t best = 0;
  double best_value = 0.0;
  for (std::size_t i = 0; i < places; ++i) {
    double value = 0.0;
    for (std::size_t j = 0; j < values.size(); ++j)
      value += weights[i * values.size() + j] * values[j];
    if (i == 0 || value < best_value) {
      best = i;
      best_value = value;
    }
  }
  return best;
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

// The log objective, cut off well above its minimum: there the landscape is a cliff (particles
// jam), which would teach the surrogate lengths that are too short for the valley.
std::vector<double> surrogate_values(std::span<const double> objectives) {
  constexpr double cut = 20.0;  // times the lowest objective
  const double lowest_objective = *std::min_element(objectives.begin(), objectives.end());
  std::vector<double> values;
  for (const double objective : objectives)
    values.push_back(std::log(std::min(objective, cut * lowest_objective)));
  return values;
}

}  // namespace

std::vector<std::vector<double>> draw_objectives(const Problem& problem,
                                                 std::span<const Evaluation> evaluations,
                                                 const BootstrapOptions& options) {
  std::vector<std::vector<datasets::Trajectories>> tracks;
  for (const Evaluation& evaluation : evaluations)
    tracks.push_back(completed_tracks(evaluation.runs));
  const std::vector<std::uint64_t> seeds = make_seeds(options.seed, "bootstrap", options.draws);
  std::vector<std::vector<double>> drawn(static_cast<std::size_t>(options.draws));
  parallel_for(options.draws, options.jobs, [&](int draw) {
    Generator generator(seeds[static_cast<std::size_t>(draw)]);
    // A draw of one replicate only has no spread left in it; it is drawn again.
    std::vector<int> replicate_weights;
    do {
      replicate_weights = draw_weights(problem.replicates.size(), generator);
    } while (!spread_over_two(replicate_weights));
    const Band band = measure(problem.replicates, replicate_weights);
    for (const auto& runs : tracks) {
      const datasets::Trajectories mean =
          mean_track(measure(runs, draw_weights(runs.size(), generator)));
      drawn[static_cast<std::size_t>(draw)].push_back(objective(band, problem.target.widths, mean));
    }
  });
  return drawn;
}

double small_sample_stretch(std::size_t replicates) {
  const auto n = static_cast<double>(replicates);
  return critical_value(Critical::student_t, static_cast<int>(replicates)) / 1.96 *
         std::sqrt(n / (n - 1.0));
}

double range_of_noise(const Problem& problem,
                      std::span<const Evaluation> evaluations,
                      const BootstrapOptions& options) {
  // 95 % quantile of the range of k standard normal values, k = 2 to 5 (Pearson and Hartley 1966,
  // table 22).
  constexpr std::array<double, 6> range_95 = {0.0, 0.0, 2.77, 3.31, 3.63, 3.86};
  const auto drawn = draw_objectives(problem, evaluations, options);
  // The standard deviation of a single objective, from that of the differences, which common
  // replicates leave.
  double variance = 0.0;
  int pairs = 0;
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    for (std::size_t j = i + 1; j < evaluations.size(); ++j) {
      double mean = 0.0;
      for (const auto& draw : drawn)
        mean += (draw[i] - draw[j]) / static_cast<double>(drawn.size());
      for (const auto& draw : drawn) {
        variance += std::pow(draw[i] - draw[j] - mean, 2) / static_cast<double>(drawn.size() - 1);
      }
      ++pairs;
    }
  }
  const std::size_t count = std::min(evaluations.size(), range_95.size() - 1);
  return range_95[count] * small_sample_stretch(problem.replicates.size()) *
         std::sqrt(0.5 * variance / std::max(1, pairs));
}

Bootstrap bootstrap_minimum(const Problem& problem,
                            std::span<const Evaluation> evaluations,
                            const ParameterSpace& space,
                            const BootstrapOptions& options) {
  // 1. The surrogate on all replicates
  std::vector<Evaluation> usable;
  std::vector<UnitPoint> points;
  std::vector<double> objectives;
  std::vector<double> noise;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.failed > 0) continue;
    usable.push_back(evaluation);
    points.push_back(space.to_unit(evaluation.parameters));
    objectives.push_back(evaluation.objective);
    noise.push_back(objective_noise(problem.target, evaluation.runs) / evaluation.objective);
  }
  const std::vector<double> values = surrogate_values(objectives);
  const Surrogate surrogate(points, values, noise);
  const std::vector<UnitPoint> places = grid(space.dimension());
  const std::vector<double> weights = surrogate.prediction_weights(places);
  Bootstrap bootstrap;
  bootstrap.minimum = places[lowest(weights, values, places.size())];
  bootstrap.leave_one_out_error = surrogate.leave_one_out_error();
  bootstrap.value_spread = surrogate.value_spread();

  // 2. The same minimum for every draw
  for (const auto& drawn : draw_objectives(problem, usable, options)) {
    bootstrap.draws.push_back(places[lowest(weights, surrogate_values(drawn), places.size())]);
  }

  // 3. Percentiles, stretched
  const double stretch = small_sample_stretch(problem.replicates.size());
  for (std::size_t d = 0; d < space.dimension(); ++d) {
    std::vector<double> coordinates;
    for (const UnitPoint& draw : bootstrap.draws) coordinates.push_back(draw[d]);
    const double centre = bootstrap.minimum[d];
    bootstrap.interval.push_back(
        {std::clamp(
             centre - stretch * std::max(0.0, centre - percentile(coordinates, 0.025)), 0.0, 1.0),
         std::clamp(
             centre + stretch * std::max(0.0, percentile(coordinates, 0.975) - centre), 0.0, 1.0)});
  }
  return bootstrap;
}

}  // namespace graintruth::calibrate
