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

// sqrt(n / (n - 1)): what the bootstrap of n replicates lacks.
double small_sample_factor(std::size_t replicates) {
  const auto n = static_cast<double>(replicates);
  return std::sqrt(n / (n - 1.0));
}

// Standard deviation over draws of the difference between two evaluations.
double difference_deviation(const std::vector<std::vector<double>>& drawn,
                            std::size_t i,
                            std::size_t j) {
  const auto n = static_cast<double>(drawn.size());
  double mean = 0.0;
  for (const auto& draw : drawn) mean += (draw[i] - draw[j]) / n;
  double squares = 0.0;
  for (const auto& draw : drawn) squares += std::pow(draw[i] - draw[j] - mean, 2);
  return std::sqrt(squares / (n - 1.0));
}

// A regular grid over the unit cube, fine against any interval that matters; one dimension may be
// held.
std::vector<UnitPoint> grid(std::size_t dimension, int fixed, double value) {
  const int side = dimension == 1 ? 201 : dimension == 2 ? 61 : 25;
  std::vector<UnitPoint> places = {UnitPoint{}};
  for (std::size_t d = 0; d < dimension; ++d) {
    std::vector<UnitPoint> longer;
    const bool is_held = static_cast<int>(d) == fixed;
    for (const UnitPoint& place : places) {
      for (int i = 0; i < (is_held ? 1 : side); ++i) {
        longer.push_back(place);
        longer.back().push_back(is_held ? value : static_cast<double>(i) / (side - 1));
      }
    }
    places = std::move(longer);
  }
  return places;
}

// One end of one parameter's interval on its way.
struct End {
  std::size_t dimension;
  double direction;  // -1 towards the lower bound, +1 towards the upper
  double inside;     // outermost compatible value in the unit range
  double outside;    // innermost incompatible one beyond it; the bound while none is known
  bool bracketed = false;
  double step;

  double bound() const { return direction < 0.0 ? 0.0 : 1.0; }
  bool is_known(double tolerance) const { return std::abs(outside - inside) <= tolerance; }
  double next() const {
    if (bracketed) return 0.5 * (inside + outside);
    return std::clamp(inside + direction * step, 0.0, 1.0);
  }
  void learn(double value, bool is_compatible) {
    if (is_compatible) {
      inside = value;
      step *= 2.0;
    } else {
      outside = value;
      bracketed = true;
    }
  }
  // A compatible bound leaves the interval open; otherwise the end lies between the last two
  // values.
  bool is_open() const { return !bracketed && inside == bound(); }
  double end() const { return is_open() ? bound() : bracketed ? 0.5 * (inside + outside) : inside; }
};

}  // namespace

const Evaluation& best_of(std::span<const Evaluation> evaluations) {
  return *std::min_element(evaluations.begin(),
                           evaluations.end(),
                           [](const auto& a, const auto& b) { return a.objective < b.objective; });
}

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
      const double value =
          runs.empty() ? objective_of_rest(band, problem.target.widths)
                       : objective(band,
                                   problem.target.widths,
                                   mean_track(measure(runs, draw_weights(runs.size(), generator))));
      drawn[static_cast<std::size_t>(draw)].push_back(value);
    }
  });
  return drawn;
}

Excess excess_over(const Problem& problem,
                   const Evaluation& reference,
                   const Evaluation& evaluation,
                   const BootstrapOptions& options) {
  const std::vector<Evaluation> both = {reference, evaluation};
  const std::size_t n = problem.replicates.size();
  return {evaluation.objective - reference.objective,
          critical_value(Critical::student_t, static_cast<int>(n)) * small_sample_factor(n) *
              difference_deviation(draw_objectives(problem, both, options), 0, 1)};
}

std::vector<Evaluation> compatible_with(const Problem& problem,
                                        const Evaluation& reference,
                                        std::span<const Evaluation> evaluations,
                                        const BootstrapOptions& options) {
  // So much worse than the reference that no bootstrap is needed to tell.
  constexpr double hopeless = 6.0;
  std::vector<Evaluation> compatible;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.objective > hopeless * reference.objective) continue;
    if (excess_over(problem, reference, evaluation, options).is_compatible())
      compatible.push_back(evaluation);
  }
  return compatible;
}

Surrogate fit_surrogate(const Problem& problem,
                        std::span<const Evaluation> evaluations,
                        const ParameterSpace& space) {
  constexpr double cut = 20.0;  // times the lowest objective
  const double highest = cut * best_of(evaluations).objective;
  std::vector<UnitPoint> points;
  std::vector<double> values;
  std::vector<double> noise;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.failed > 0) continue;
    points.push_back(space.to_unit(evaluation.parameters));
    values.push_back(std::log(std::min(evaluation.objective, highest)));
    noise.push_back(objective_noise(problem.target, evaluation.runs) / evaluation.objective);
  }
  return Surrogate(points, values, noise);
}

UnitPoint surrogate_minimum(const Surrogate& surrogate,
                            std::size_t dimension,
                            int fixed,
                            double value) {
  const std::vector<UnitPoint> places = grid(dimension, fixed, value);
  const std::vector<Surrogate::Prediction> predictions = surrogate.predict(places);
  // Mean plus standard deviation: a minimum that is promised far from every evaluation is not
  // believed.
  const auto lowest =
      std::min_element(predictions.begin(), predictions.end(), [](const auto& a, const auto& b) {
        return a.mean + a.standard_deviation < b.mean + b.standard_deviation;
      });
  return places[static_cast<std::size_t>(lowest - predictions.begin())];
}

std::vector<Profile> profile_parameters(
    const Problem& problem,
    const ParameterSpace& space,
    std::span<const Evaluation> evaluations,
    const std::function<std::vector<Evaluation>(const std::vector<ParameterSet>&)>& evaluate,
    const ProfileOptions& options) {
  const Surrogate surrogate = fit_surrogate(problem, evaluations, space);
  const Evaluation reference = best_of(evaluations);
  const UnitPoint centre = space.to_unit(reference.parameters);
  std::vector<Profile> profiles;
  std::vector<End> ends;
  for (std::size_t d = 0; d < space.dimension(); ++d) {
    const std::string& name = space.tuned()[d].name;
    profiles.push_back(
        {.name = name,
         .points = {{value_of(reference.parameters, name), reference.objective, {}}}});
    for (const double direction : {-1.0, 1.0}) {
      ends.push_back({.dimension = d,
                      .direction = direction,
                      .inside = centre[d],
                      .outside = direction < 0.0 ? 0.0 : 1.0,
                      .step = options.first_step});
    }
  }

  for (const Evaluation& evaluation :
       compatible_with(problem, reference, evaluations, options.bootstrap)) {
    const UnitPoint point = space.to_unit(evaluation.parameters);
    for (End& end : ends) {
      if ((point[end.dimension] - end.inside) * end.direction > 0.0)
        end.inside = point[end.dimension];
    }
  }

  for (int round = 0; round < options.rounds; ++round) {
    // 1. The next value of every end, with the other parameters at the surrogate's best for it
    std::vector<End*> open;
    std::vector<ParameterSet> places;
    for (End& end : ends) {
      if (end.is_known(options.tolerance)) continue;
      open.push_back(&end);
      places.push_back(space.from_unit(surrogate_minimum(
          surrogate, space.dimension(), static_cast<int>(end.dimension), end.next())));
    }
    if (open.empty()) break;
    // 2. All of them simulated at once, and tested
    const std::vector<Evaluation> tried = evaluate(places);
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Excess excess = excess_over(problem, reference, tried[i], options.bootstrap);
      Profile& profile = profiles[open[i]->dimension];
      profile.points.push_back({value_of(places[i], profile.name), tried[i].objective, excess});
      open[i]->learn(open[i]->next(), excess.is_compatible());
    }
  }

  // 3. Ends to intervals
  for (const End& end : ends) {
    Profile& profile = profiles[end.dimension];
    UnitPoint point = centre;
    point[end.dimension] = end.end();
    const double value = value_of(space.from_unit(point), profile.name);
    (end.direction < 0.0 ? profile.interval.lower : profile.interval.upper) = value;
    (end.direction < 0.0 ? profile.open_below : profile.open_above) = end.is_open();
  }
  for (Profile& profile : profiles) {
    std::sort(profile.points.begin(), profile.points.end(), [](const auto& a, const auto& b) {
      return a.value < b.value;
    });
  }
  return profiles;
}

}  // namespace graintruth::calibrate
