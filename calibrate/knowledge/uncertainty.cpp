#include "calibrate/knowledge/uncertainty.h"

#include <algorithm>
#include <cmath>

#include "calibrate/flow/median.h"

namespace graintruth::calibrate {

namespace {

constexpr std::size_t few_lowest = 9;  // evaluations that tell of chance near the best

// One end of one parameter's interval on its way. Values are those of the unit range.
struct End {
  std::size_t dimension;
  double direction;  // -1 towards the lower bound, +1 towards the upper
  double tolerance;  // to which it is wanted at most
  double limit;      // where it ends at the latest: the bound, or where the prior alone rules out
  bool ruled_out;    // the latter
  std::vector<std::pair<double, std::size_t>> tried;  // value, number of the evaluation
  double best = 0.0;                                  // value of the best evaluation
  double inside = 0.0;                                // outermost compatible value
  double outside = 0.0;  // innermost incompatible one beyond it that was tried; else the limit
  bool bracketed = false;

  bool is_beyond(double a, double b) const { return (a - b) * direction > 0.0; }
  // To a share of its distance from the best.
  bool is_known() const {
    constexpr double share = 0.25, least = 0.003;
    const double wanted = std::max(least, share * std::abs(outside - best));
    return std::abs(outside - inside) <= std::min(tolerance, wanted);
  }
  EndKind kind() const {
    if (bracketed) return EndKind::found;
    return is_known() ? EndKind::open : EndKind::search_ended;
  }
  // Steps that double until the end is bracketed, then bisection.
  double next(double first_step) const {
    if (bracketed) return 0.5 * (inside + outside);
    const double step = first_step * std::pow(2.0, static_cast<double>(tried.size()));
    return std::clamp(inside + direction * step, 0.0, 1.0);
  }
};

// An end before anything was tried. J is nowhere below the lowest that the data gave, so that a
// value is incompatible wherever its prior alone costs more than what is allowed and what the best
// total lies above that J.
End end_of(const ParameterSpace& space,
           std::span<const Evaluation> evaluations,
           std::size_t dimension,
           double direction,
           const ProfileOptions& options) {
  constexpr double share = 0.25;  // of a prior's standard uncertainty, to which an end is wanted
  End end{dimension, direction, options.tolerance, direction < 0.0 ? 0.0 : 1.0, false, {}};
  const datasets::TunedParameter& tuned = space.tuned()[dimension];
  const Prior& prior = options.prior;
  if (!prior.is_weighed() || !tuned.prior) return end;
  const double least = best_of(evaluations).objective;
  const double reach =
      prior.reach(tuned, prior.allowed() + prior.total(best_of(evaluations, prior)) - least);
  const double range = tuned.upper - tuned.lower;
  const double limit = (tuned.prior->value + direction * reach - tuned.lower) / range;
  end.tolerance = std::min(end.tolerance, share * tuned.prior->standard_uncertainty / range);
  if (!end.is_beyond(end.limit, limit)) return end;
  end.limit = limit;
  end.ruled_out = true;
  return end;
}

// What is known of all evaluations against the best of them.
struct Standing {
  std::size_t best = 0;
  std::vector<Excess> excess;
  // Whose seeds disagree far more than those of the lowest do, a run in six being jammed, say: much
  // is allowed to them, but that tells nothing of others.
  std::vector<char> is_erratic;

  // What a compatible evaluation says is allowed to others; else 0.
  double allowed_by(std::size_t evaluation) const {
    const Excess& one = excess[evaluation];
    return one.is_compatible() && !is_erratic[evaluation] ? one.allowed : 0.0;
  }
};

Standing compare_all(const Comparison& comparison,
                     std::span<const Evaluation> all,
                     const PooledChance& chance,
                     const Prior& prior) {
  constexpr double erratic = 3.0;  // times the noise of the lowest
  const double usual_noise = noise_of_lowest(comparison, all);
  Standing standing;
  standing.best = static_cast<std::size_t>(&best_of(all, prior) - all.data());
  const Evaluation& best = all[standing.best];
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_near = i != standing.best && (prior.is_weighed() || !is_hopeless(all[i], best));
    standing.excess.push_back(is_near ? excess_over(comparison, best, all[i], chance, prior)
                                      : Excess{all[i].objective - best.objective, 0.0});
    standing.is_erratic.push_back(comparison.noise(all[i].runs) > erratic * usual_noise);
  }
  return standing;
}

void bracket(const ParameterSpace& space,
             std::span<const Evaluation> all,
             const Standing& standing,
             End& end) {
  end.best = space.to_unit(all[standing.best].parameters)[end.dimension];
  end.inside = end.best;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double value = space.to_unit(all[i].parameters)[end.dimension];
    if (standing.excess[i].is_compatible() && end.is_beyond(value, end.inside)) end.inside = value;
  }
  end.outside = end.limit;
  end.bracketed = end.ruled_out && end.is_beyond(end.limit, end.inside);
  for (const auto& [value, evaluation] : end.tried) {
    if (standing.excess[evaluation].is_compatible() || !end.is_beyond(value, end.inside)) continue;
    if (end.bracketed && end.is_beyond(value, end.outside)) continue;
    end.outside = value;
    end.bracketed = true;
  }
}

bool is_held(std::span<const HeldCoordinate> held, std::size_t dimension) {
  return std::any_of(held.begin(), held.end(), [&](const HeldCoordinate& coordinate) {
    return coordinate.dimension == dimension;
  });
}

// A regular grid of `side` places in every dimension that is not held, within `reach` of `centre`
// and inside the unit cube.
std::vector<UnitPoint> grid_around(const UnitPoint& centre,
                                   std::span<const HeldCoordinate> held,
                                   double reach,
                                   int side) {
  std::vector<UnitPoint> places = {UnitPoint{}};
  for (std::size_t d = 0; d < centre.size(); ++d) {
    std::vector<UnitPoint> longer;
    const bool fixed = is_held(held, d);
    for (const UnitPoint& place : places) {
      for (int i = 0; i < (fixed ? 1 : side); ++i) {
        longer.push_back(place);
        const double offset = fixed ? 0.0 : reach * (2.0 * i / (side - 1) - 1.0);
        longer.back().push_back(std::clamp(centre[d] + offset, 0.0, 1.0));
      }
    }
    places = std::move(longer);
  }
  return places;
}

// Places a side of a first grid that is fine against any interval that matters.
int first_side(std::size_t dimension) { return dimension == 1 ? 201 : dimension == 2 ? 61 : 17; }

UnitPoint lowest_of(const Landscape& landscape, const std::vector<UnitPoint>& places) {
  const std::vector<double> values = landscape(places);
  return places[static_cast<std::size_t>(std::min_element(values.begin(), values.end()) -
                                         values.begin())];
}

}  // namespace

std::string_view name_of(EndKind end) {
  switch (end) {
    case EndKind::found:
      return "found";
    case EndKind::open:
      return "open";
    case EndKind::search_ended:
      return "budget_ended";
  }
  return "";
}

double noise_of_lowest(const Comparison& comparison, std::span<const Evaluation> evaluations) {
  constexpr double least = 1.0e-9;  // no logarithm of nothing
  std::vector<const Evaluation*> ranked = by_objective(evaluations);
  ranked.resize(std::min(few_lowest, ranked.size()));
  std::vector<double> noise;
  for (const Evaluation* evaluation : ranked) noise.push_back(comparison.noise(evaluation->runs));
  std::sort(noise.begin(), noise.end());
  return std::max(least, noise[noise.size() / 2]);
}

std::vector<const Evaluation*> by_objective(std::span<const Evaluation> evaluations,
                                            const Prior& prior) {
  std::vector<const Evaluation*> ranked;
  for (const Evaluation& evaluation : evaluations) ranked.push_back(&evaluation);
  std::stable_sort(ranked.begin(), ranked.end(), [&](auto a, auto b) {
    return prior.total(*a) < prior.total(*b);
  });
  return ranked;
}

const Evaluation& best_of(std::span<const Evaluation> evaluations, const Prior& prior) {
  return *std::min_element(
      evaluations.begin(), evaluations.end(), [&](const auto& a, const auto& b) {
        return prior.total(a) < prior.total(b);
      });
}

PooledChance pool_chance(const Comparison& comparison,
                         std::span<const Evaluation> evaluations,
                         double roughness) {
  const Evaluation& best = best_of(evaluations);
  std::vector<double> costs;
  for (const Evaluation& evaluation : evaluations) {
    if (is_hopeless(evaluation, best)) continue;
    const ReplicateVariance variance = comparison.replicate_variance(best, evaluation);
    if (variance.by_own_widths > 0.0)
      costs.push_back(variance.by_widths_of_others / variance.by_own_widths);
  }
  // Where seeds scatter as they do near the best
  std::vector<Evaluation> lowest;
  for (const Evaluation* evaluation : by_objective(evaluations)) {
    if (lowest.size() == few_lowest || is_hopeless(*evaluation, best)) break;
    lowest.push_back(*evaluation);
  }
  return {roughness, costs.empty() ? 1.0 : median(costs), comparison.seed_scatter(lowest)};
}

Excess excess_over(const Comparison& comparison,
                   const Evaluation& reference,
                   const Evaluation& evaluation,
                   const PooledChance& chance,
                   const Prior& prior) {
  return {prior.total(evaluation) - prior.total(reference),
          prior.is_weighed() ? prior.allowed()
                             : comparison.allowed_excess(reference, evaluation, chance)};
}

double largest_allowed_excess(const Comparison& comparison,
                              const ParameterSpace& space,
                              std::span<const Evaluation> evaluations) {
  const PooledChance chance = pool_chance(
      comparison, evaluations, fit_surrogate(comparison, evaluations, space).roughness());
  double largest = 0.0;
  const Standing standing = compare_all(comparison, evaluations, chance, {});
  for (std::size_t i = 0; i < evaluations.size(); ++i)
    largest = std::max(largest, standing.allowed_by(i));
  return largest;
}

std::vector<Evaluation> compatible_with(const Comparison& comparison,
                                        const Evaluation& reference,
                                        std::span<const Evaluation> evaluations,
                                        const PooledChance& chance,
                                        const Prior& prior) {
  std::vector<Evaluation> compatible;
  for (const Evaluation& evaluation : evaluations) {
    if (!prior.is_weighed() && is_hopeless(evaluation, reference)) continue;
    if (excess_over(comparison, reference, evaluation, chance, prior).is_compatible())
      compatible.push_back(evaluation);
  }
  return compatible;
}

Surrogate fit_surrogate(const Comparison& comparison,
                        std::span<const Evaluation> evaluations,
                        const ParameterSpace& space) {
  constexpr double cut = 20.0;  // times the lowest objective
  const double floor = noise_of_lowest(comparison, evaluations);
  const double highest = cut * (best_of(evaluations).objective + floor);
  std::vector<UnitPoint> points;
  std::vector<double> values;
  std::vector<double> noise;
  for (const Evaluation& evaluation : evaluations) {
    if (2 * evaluation.failed > static_cast<int>(evaluation.runs.size())) continue;
    points.push_back(space.to_unit(evaluation.parameters));
    const double value = std::min(evaluation.objective + floor, highest);
    values.push_back(std::log(value));
    noise.push_back(comparison.noise(evaluation.runs) / value);
  }
  return Surrogate(points, values, noise);
}

Surrogate with_prior(Surrogate surrogate, const ParameterSpace& space, const Prior& prior) {
  if (!prior.is_weighed()) return surrogate;
  return surrogate.plus(
      [space, prior](const UnitPoint& place) { return prior.penalty(space.from_unit(place)); });
}

UnitPoint minimum_of(const Landscape& landscape,
                     std::size_t dimension,
                     std::span<const HeldCoordinate> held) {
  constexpr int zooms = 3;  // each of a quarter of the last grid's cell: valleys can be narrow
  constexpr int zoomed_side = 9;
  UnitPoint centre(dimension, 0.5);
  for (const HeldCoordinate& coordinate : held) centre[coordinate.dimension] = coordinate.value;
  const int side = first_side(dimension);
  UnitPoint lowest = lowest_of(landscape, grid_around(centre, held, 0.5, side));
  double cell = 1.0 / (side - 1);
  for (int zoom = 0; zoom < zooms; ++zoom) {
    lowest = lowest_of(landscape, grid_around(lowest, held, cell, zoomed_side));
    cell *= 0.25;
  }
  return lowest;
}

// Mean plus standard deviation: a minimum that is promised far from every evaluation is not
// believed.
Landscape landscape_of(const Surrogate& surrogate) {
  return [&surrogate](std::span<const UnitPoint> places) {
    std::vector<double> values;
    for (const Surrogate::Prediction& prediction : surrogate.predict(places))
      values.push_back(prediction.mean + prediction.standard_deviation);
    return values;
  };
}

Landscape landscape_of(const Emulator& emulator, const ParameterSpace& space, const Prior& prior) {
  return [&emulator, &space, &prior](std::span<const UnitPoint> places) {
    std::vector<double> totals = emulator.objectives(places);
    for (std::size_t i = 0; i < places.size(); ++i)
      totals[i] += prior.penalty(space.from_unit(places[i]));
    return totals;
  };
}

std::vector<Profile> profile_parameters(
    const Comparison& comparison,
    const ParameterSpace& space,
    std::span<const Evaluation> evaluations,
    const std::function<std::vector<Evaluation>(const std::vector<ParameterSet>&)>& evaluate,
    const ProfileOptions& options) {
  const PooledChance chance = pool_chance(
      comparison, evaluations, fit_surrogate(comparison, evaluations, space).roughness());
  std::vector<Evaluation> all(evaluations.begin(), evaluations.end());
  const auto is_left_out = [&](std::size_t d) {
    const auto& names = options.left_out;
    return std::find(names.begin(), names.end(), space.tuned()[d].name) != names.end();
  };
  std::vector<End> ends;
  for (std::size_t d = 0; d < space.dimension(); ++d) {
    if (is_left_out(d)) continue;
    for (const double direction : {-1.0, 1.0})
      ends.push_back(end_of(space, evaluations, d, direction, options));
  }
  Standing standing;
  const auto look = [&] {
    standing = compare_all(comparison, all, chance, options.prior);
    for (End& end : ends) bracket(space, all, standing, end);
  };

  look();
  std::optional<Emulator> emulator;
  for (int round = 0; round < options.rounds; ++round) {
    // 1. The next value of every end, with the other parameters where all evaluations so far say
    // that their best for it is
    emulator = Emulator(comparison, all, space, emulator ? &*emulator : nullptr);
    const Landscape landscape = landscape_of(*emulator, space, options.prior);
    std::vector<ParameterSet> places;
    for (End& end : ends) {
      if (end.is_known()) continue;
      if (static_cast<int>(all.size() - evaluations.size() + places.size()) >=
          options.max_evaluations)
        break;
      const double value = end.next(options.first_step);
      end.tried.emplace_back(value, all.size() + places.size());
      const HeldCoordinate held{end.dimension, value};
      places.push_back(space.from_unit(minimum_of(landscape, space.dimension(), {&held, 1})));
    }
    if (places.empty()) break;
    // 2. All of them simulated at once, and everything compared anew: one may be the best of all
    const std::vector<Evaluation> results = evaluate(places);
    all.insert(all.end(), results.begin(), results.end());
    look();
  }

  // 3. Ends to intervals
  const Evaluation& best = all[standing.best];
  std::vector<Profile> profiles;
  for (std::size_t d = 0; d < space.dimension(); ++d) {
    if (is_left_out(d)) continue;
    Profile profile{.name = space.tuned()[d].name};
    profile.best = value_of(best.parameters, profile.name);
    profile.points.push_back({profile.best, best.objective, {}});
    for (const End& end : ends) {
      if (end.dimension != d) continue;
      UnitPoint point = space.to_unit(best.parameters);
      point[d] = end.outside;
      const double value = value_of(space.from_unit(point), profile.name);
      (end.direction < 0.0 ? profile.interval.lower : profile.interval.upper) = value;
      (end.direction < 0.0 ? profile.below : profile.above) = end.kind();
      for (const auto& [unit, evaluation] : end.tried) {
        if (evaluation == standing.best) continue;
        profile.points.push_back({value_of(all[evaluation].parameters, profile.name),
                                  all[evaluation].objective,
                                  standing.excess[evaluation]});
      }
    }
    std::sort(profile.points.begin(), profile.points.end(), [](const auto& a, const auto& b) {
      return a.value < b.value;
    });
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

}  // namespace graintruth::calibrate
