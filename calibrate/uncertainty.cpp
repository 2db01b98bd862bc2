#include "calibrate/uncertainty.h"

#include <algorithm>
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

}  // namespace

Bootstrap bootstrap_minimum(const Problem& problem,
                            std::span<const Evaluation> evaluations,
                            const ParameterSpace& space,
                            const BootstrapOptions& options) {
  // 1. The surrogate of the log objective on all replicates
  std::vector<const Evaluation*> usable;
  std::vector<std::vector<datasets::Trajectories>> tracks;
  std::vector<UnitPoint> points;
  std::vector<double> values;
  std::vector<double> noise;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.failed > 0) continue;
    usable.push_back(&evaluation);
    tracks.push_back(completed_tracks(evaluation.runs));
    points.push_back(space.to_unit(evaluation.parameters));
    values.push_back(std::log(evaluation.objective));
    noise.push_back(objective_noise(problem.target, evaluation.runs) / evaluation.objective);
  }
  const Surrogate surrogate(points, values, noise);
  const std::vector<UnitPoint> places = grid(space.dimension());
  const std::vector<double> weights = surrogate.prediction_weights(places);
  Bootstrap bootstrap;
  bootstrap.minimum = places[lowest(weights, values, places.size())];
  bootstrap.leave_one_out_error = surrogate.leave_one_out_error();
  bootstrap.value_spread = surrogate.value_spread();

  // 2. The same minimum for replicates and seeds drawn anew
  const std::size_t replicates = problem.replicates.size();
  bootstrap.draws.resize(static_cast<std::size_t>(options.draws));
  const std::vector<std::uint64_t> seeds = make_seeds(options.seed, "bootstrap", options.draws);
  parallel_for(options.draws, options.jobs, [&](int draw) {
    Generator generator(seeds[static_cast<std::size_t>(draw)]);
    // A draw of one replicate only has no spread left in it; it is drawn again.
    std::vector<int> replicate_weights;
    do {
      replicate_weights = draw_weights(replicates, generator);
    } while (!spread_over_two(replicate_weights));
    const Band band = measure(problem.replicates, replicate_weights);
    std::vector<double> drawn(usable.size());
    for (std::size_t i = 0; i < usable.size(); ++i) {
      const std::vector<int> run_weights = draw_weights(tracks[i].size(), generator);
      drawn[i] = std::log(
          objective(band, problem.target.widths, mean_track(measure(tracks[i], run_weights))));
    }
    bootstrap.draws[static_cast<std::size_t>(draw)] = places[lowest(weights, drawn, places.size())];
  });

  // 3. Percentiles, stretched for the small number of replicates
  const auto n = static_cast<double>(replicates);
  const double stretch = critical_value(Critical::student_t, static_cast<int>(replicates)) / 1.96 *
                         std::sqrt(n / (n - 1.0));
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
