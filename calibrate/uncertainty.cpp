#include "calibrate/uncertainty.h"

#include <algorithm>
#include <cmath>

namespace graintruth::calibrate {

namespace {

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

Excess excess_over(const Comparison& comparison,
                   const Evaluation& reference,
                   const Evaluation& evaluation,
                   const BootstrapOptions& options) {
  const std::vector<Evaluation> both = {reference, evaluation};
  return {evaluation.objective - reference.objective,
          comparison.significance() *
              difference_deviation(comparison.draw_objectives(both, options), 0, 1)};
}

std::vector<Evaluation> compatible_with(const Comparison& comparison,
                                        const Evaluation& reference,
                                        std::span<const Evaluation> evaluations,
                                        const BootstrapOptions& options) {
  // So much worse than the reference that no bootstrap is needed to tell.
  constexpr double hopeless = 6.0;
  std::vector<Evaluation> compatible;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.objective > hopeless * reference.objective) continue;
    if (excess_over(comparison, reference, evaluation, options).is_compatible())
      compatible.push_back(evaluation);
  }
  return compatible;
}

Surrogate fit_surrogate(const Comparison& comparison,
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
    noise.push_back(comparison.noise(evaluation.runs) / evaluation.objective);
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
    const Comparison& comparison,
    const ParameterSpace& space,
    std::span<const Evaluation> evaluations,
    const std::function<std::vector<Evaluation>(const std::vector<ParameterSet>&)>& evaluate,
    const ProfileOptions& options) {
  const Surrogate surrogate = fit_surrogate(comparison, evaluations, space);
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
       compatible_with(comparison, reference, evaluations, options.bootstrap)) {
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
      const Excess excess = excess_over(comparison, reference, tried[i], options.bootstrap);
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
