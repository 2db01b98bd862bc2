#include "calibrate/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calibrate/optimiser.h"

namespace graintruth::calibrate {

namespace {

constexpr double design_share = 0.3;    // of the budget goes to the low-discrepancy design
constexpr double profile_share = 0.25;  // of the budget is kept for the ends of the intervals
constexpr int gate_places = 2;
constexpr double gate_cost = 1.0 + 2.0 + 4.0;  // of the step, its half and its quarter at one place
constexpr int choice_seeds_per_confirmation =
    2;  // the choice between two candidates takes more seeds than the score
constexpr double polish_step = 0.1;  // of each range; first step of the local searches
constexpr double last_step = 0.03;   // the same of the last one
constexpr std::array<double, 2> basin_shares = {
    0.4, 0.25};  // of the local searches' budget; the rest is the last one's
constexpr std::size_t effect_bases = 3;  // places from which a parameter's effect is looked for
constexpr int stall_evaluations = 12;    // without gain end a local search
constexpr double basin_distance = 0.25;  // of a range; closer starts would find the same minimum
constexpr std::array<double, 2> effect_levels = {
    0.0, 1.0};  // ends of the range, beside the best point itself

struct Change {
  double size;   // of the objective
  double noise;  // what other replicates and seeds could explain of it
};

double largest_allowed_excess(std::span<const Profile> profiles) {
  double largest = 0.0;
  for (const Profile& profile : profiles) {
    for (const ProfilePoint& point : profile.points)
      largest = std::max(largest, point.excess.allowed);
  }
  return largest;
}

PosteriorMarginal marginal(const ParameterSpace& space,
                           const Posterior& posterior,
                           std::size_t dimension) {
  PosteriorMarginal one{.name = space.tuned()[dimension].name};
  std::vector<double> values;
  for (const UnitPoint& draw : posterior.draws)
    values.push_back(value_of(space.from_unit(draw), one.name));
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  for (const double value : values) one.mean += value / n;
  for (const double value : values)
    one.standard_deviation += (value - one.mean) * (value - one.mean) / (n - 1.0);
  one.standard_deviation = std::sqrt(one.standard_deviation);
  const std::size_t tail = values.size() / 40;
  one.credible = {values[tail], values[values.size() - 1 - tail]};
  return one;
}

// Largest difference of any coordinate.
double distance_between(const UnitPoint& a, const UnitPoint& b) {
  double distance = 0.0;
  for (std::size_t d = 0; d < a.size(); ++d) distance = std::max(distance, std::abs(a[d] - b[d]));
  return distance;
}

}  // namespace

std::string_view name_of(ParameterStatus status) {
  switch (status) {
    case ParameterStatus::tuned:
      return "tuned";
    case ParameterStatus::fixed:
      return "fixed";
    case ParameterStatus::at_bound:
      return "at_bound";
    case ParameterStatus::not_identified:
      return "not_identified";
  }
  return "";
}

Search::Search(const datasets::Experiment& experiment,
               Ensemble& ensemble,
               const CalibrationOptions& options,
               int later_simulations)
    : experiment_(experiment),
      ensemble_(ensemble),
      options_(options),
      later_simulations_(later_simulations),
      search_seeds_(make_seeds(options.seed, "search", options.search_seeds)),
      space_(experiment.tuned, bench_parameters(experiment)) {}

void Search::run() {
  timed("time step", [&] { choose_step(); });
  timed("design", [&] { explore(); });
  timed("effects", [&] { find_effects(); });
  timed("polish", [&] { polish(); });
  timed("effects at the minimum", [&] { look_again(); });
  timed("uncertainty", [&] { find_uncertainty(); });
  timed("choice", [&] { choose(); });
}

void Search::timed(const char* name, const std::function<void()>& stage) {
  const auto start = std::chrono::steady_clock::now();
  stage_ = name;
  stage();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  result_.stages.push_back({name, taken.count()});
}

// Expected cost in simulations at the largest time step: the gate's smaller steps weigh more.
double Search::expected_cost() const {
  const double runs = static_cast<double>(ensemble_.scenes()) * options_.search_seeds;
  const double choice = static_cast<double>(ensemble_.scenes()) * 2 *
                        choice_seeds_per_confirmation * options_.confirmation_seeds;
  return (gate_places * gate_cost + options_.budget) * runs + choice + later_simulations_;
}

// `weight` is the mean cost of a simulation of the batch.
SimulationProgress Search::reporter(double weight) {
  return [this, weight, before = cost_](int done, int, bool) {
    cost_ = before + weight * done;
    if (!options_.progress) return;
    options_.progress({.stage = stage_,
                       .evaluations = static_cast<int>(result_.evaluations.size()),
                       .budget = options_.budget,
                       .share = std::min(1.0, cost_ / expected_cost()),
                       .best = result_.evaluations.empty() ? std::nan("") : best().objective,
                       .finished = result_.evaluations});
  };
}

// Counts what a batch cost, and gives up when too much of it fails.
void Search::count(std::span<const Evaluation> evaluations) {
  for (const Evaluation& evaluation : evaluations) {
    result_.simulations += static_cast<int>(evaluation.runs.size());
    result_.failed += evaluation.failed;
    result_.retried += evaluation.retried;
  }
  if (result_.simulations >= 2 * static_cast<int>(ensemble_.scenes()) * options_.search_seeds &&
      result_.failed > options_.allowed_failures * result_.simulations) {
    throw TooManyFailures(
        fmt::format("{} of {} simulations failed ({}); check the rig's walls and starting places "
                    "with 'graintruth track', or "
                    "lower the bounds.",
                    result_.failed,
                    result_.simulations,
                    first_complaint(evaluations)));
  }
}

std::string Search::first_complaint(std::span<const Evaluation> evaluations) {
  for (const Evaluation& evaluation : evaluations) {
    for (const SimulatedRun& run : evaluation.runs) {
      if (run.status != RunStatus::completed) return run.message;
    }
  }
  return "in earlier stages";
}

std::vector<Evaluation> Search::search(const char* stage, const std::vector<ParameterSet>& places) {
  std::vector<EvaluationPoint> points;
  for (const ParameterSet& place : places) points.push_back({place, result_.time_step.fraction});
  std::vector<Evaluation> evaluations =
      ensemble_.evaluate(stage, points, search_seeds_, reporter());
  count(evaluations);
  result_.evaluations.insert(result_.evaluations.end(), evaluations.begin(), evaluations.end());
  return evaluations;
}

const Evaluation& Search::best() const { return best_of(result_.evaluations); }

int Search::budget_left() const {
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started_;
  if (options_.time_limit > 0.0 && taken.count() > options_.time_limit) return 0;
  return options_.budget - static_cast<int>(result_.evaluations.size());
}

// What the local searches may spend: the profiles, and a second look at what was held, are kept
// free.
int Search::polish_budget() const {
  int kept = static_cast<int>(std::lround(profile_share * options_.budget));
  for (const CalibratedParameter& parameter : result_.calibrated) {
    if (parameter.status == ParameterStatus::not_identified)
      kept += static_cast<int>(effect_levels.size() * effect_bases);
  }
  return budget_left() - kept;
}

// 1. The time step, at the centre of the box and half way from there to its lower corner, where
// particles move more.
void Search::choose_step() {
  std::vector<ParameterSet> places;
  for (const double level : {0.5, 0.25})
    places.push_back(space_.from_unit(UnitPoint(space_.dimension(), level)));
  result_.time_step = choose_time_step(
      ensemble_, places, options_.largest_time_step_fraction, search_seeds_, reporter());
  for (const TimeStepRow& row : result_.time_step.rows) {
    result_.simulations += static_cast<int>(ensemble_.scenes()) * options_.search_seeds;
    result_.failed += row.failed;
  }
  if (!result_.time_step.converged) {
    result_.warnings.push_back(
        fmt::format("The objective still changes by {:.3g} at the smallest time step tried "
                    "(fraction {:.3g}): the "
                    "result depends on the time step.",
                    result_.time_step.discretisation_error,
                    result_.time_step.fraction));
  }
}

// 2. A low-discrepancy design: above some friction particles jam, so the objective is not
// unimodal and a local search
//    alone would end where it began.
void Search::explore() {
  if (space_.dimension() == 0) return;
  const int points = std::max(8, static_cast<int>(std::lround(design_share * options_.budget)));
  std::vector<ParameterSet> places;
  for (const UnitPoint& point : low_discrepancy_points(points, space_.dimension(), options_.seed)) {
    places.push_back(space_.from_unit(point));
  }
  search("design", places);
}

// 3. What each parameter does on its own, from the best point so far: its range of the objective
// against the range that
//    replicates and seeds alone would give. What shows no effect is held at its bench value.
void Search::find_effects() {
  const ParameterSet bench = bench_parameters(experiment_);
  for (const std::string_view name : parameter_names) {
    result_.calibrated.push_back({.name = std::string(name),
                                  .value = value_of(bench, name),
                                  .bench = value_of(bench, name)});
  }
  if (space_.dimension() == 0) return;

  for (const datasets::TunedParameter& tuned : experiment_.tuned) {
    CalibratedParameter& parameter = calibrated(tuned.name);
    parameter.lower_bound = tuned.lower;
    parameter.upper_bound = tuned.upper;
    if (has_effect(parameter)) {
      parameter.status = ParameterStatus::tuned;
    } else {
      hold(parameter);
    }
  }
}

// The change of the objective at each end of the range, seen from a few places that are as good
// as the best; of those the median, because near a cliff (particles jam) any parameter seems to
// matter when it moves the cliff a little.
bool Search::has_effect(CalibratedParameter& parameter) {
  const std::vector<Evaluation> bases = compatible_evaluations(effect_bases);
  parameter.effect = 0.0;
  parameter.effect_noise = 0.0;
  bool shows = false;
  for (const double level : effect_levels) {
    std::vector<ParameterSet> places;
    for (const Evaluation& base : bases) {
      places.push_back(base.parameters);
      value_of(places.back(), parameter.name) =
          parameter.lower_bound + level * (parameter.upper_bound - parameter.lower_bound);
    }
    const std::vector<Evaluation> tried = search("effects", places);
    // What each end changes, and what other replicates and seeds could make of that
    std::vector<Change> changes;
    for (std::size_t i = 0; i < bases.size(); ++i) {
      changes.push_back(
          {std::abs(tried[i].objective - bases[i].objective),
           ensemble_.comparison().significance() *
               difference_deviation(ensemble_.comparison(), bases[i], tried[i], bootstrap())});
    }
    std::sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) {
      return a.size < b.size;
    });
    const Change& typical = changes[changes.size() / 2];
    shows = shows || typical.size > typical.noise;
    if (typical.size < parameter.effect) continue;
    parameter.effect = typical.size;
    parameter.effect_noise = typical.noise;
  }
  return shows;
}

std::vector<Evaluation> Search::compatible_evaluations(std::size_t count) const {
  const ParameterSpace box(experiment_.tuned, bench_parameters(experiment_));
  const std::vector<Evaluation> candidates =
      compatible_with(ensemble_.comparison(), best(), result_.evaluations, 0.0, bootstrap());
  std::vector<Evaluation> chosen = {best()};
  while (chosen.size() < count) {
    const Evaluation* farthest = nullptr;
    double distance = 0.0;
    for (const Evaluation& candidate : candidates) {
      double nearest = 1.0;
      for (const Evaluation& other : chosen) {
        nearest = std::min(
            nearest,
            distance_between(box.to_unit(candidate.parameters), box.to_unit(other.parameters)));
      }
      if (nearest <= distance) continue;
      distance = nearest;
      farthest = &candidate;
    }
    if (farthest == nullptr) break;
    chosen.push_back(*farthest);
  }
  return chosen;
}

BootstrapOptions Search::bootstrap() const {
  return {.seed = options_.seed, .jobs = options_.jobs};
}

void Search::hold(CalibratedParameter& parameter) {
  parameter.status = ParameterStatus::not_identified;
  space_ = space_.with_fixed(parameter.name, parameter.bench);
}

CalibratedParameter& Search::calibrated(std::string_view name) {
  for (CalibratedParameter& parameter : result_.calibrated) {
    if (parameter.name == name) return parameter;
  }
  throw std::logic_error("no such parameter");
}

// 4. Local searches: from the best points of two basins, then once more, with a smaller step,
// from the best of all.
void Search::polish() {
  result_.stop_reason = "nothing to tune";
  if (space_.dimension() == 0) return;
  result_.stop_reason = "the budget left nothing for a local search";
  const std::vector<UnitPoint> starts = distinct_starts();
  const int budget = polish_budget();
  for (std::size_t i = 0; i < starts.size(); ++i) {
    search_locally(starts[i], polish_step, static_cast<int>(basin_shares[i] * budget));
  }
  search_locally(space_.to_unit(best().parameters), last_step, polish_budget());
}

void Search::search_locally(const UnitPoint& start, double step, int budget) {
  if (budget < 1) return;
  const OptimiserOptions options{
      .max_evaluations = budget,
      .initial_step = step,
      .objective_tolerance = 0.5 * ensemble_.comparison().noise(best().runs),
      .stall_evaluations = stall_evaluations};
  const auto objective = [&](const UnitPoint& point) {
    return search("polish", {space_.from_unit(point)}).front().objective;
  };
  result_.stop_reason = minimise(objective, start, options).stop_reason;
}

// 5. Far from the minimum a small effect drowns in the noise of a large objective: what was held
// is tried once more where
//    the search ended, and joins it if it shows there.
void Search::look_again() {
  const std::size_t dimension = space_.dimension();
  for (CalibratedParameter& parameter : result_.calibrated) {
    if (parameter.status != ParameterStatus::not_identified) continue;
    if (has_effect(parameter)) parameter.status = ParameterStatus::tuned;
  }
  space_ = ParameterSpace(experiment_.tuned, bench_parameters(experiment_));
  for (CalibratedParameter& parameter : result_.calibrated) {
    if (parameter.status == ParameterStatus::not_identified) hold(parameter);
  }
  if (space_.dimension() > dimension) polish();
}

std::vector<UnitPoint> Search::distinct_starts() const {
  std::vector<const Evaluation*> ranked;
  for (const Evaluation& evaluation : result_.evaluations) ranked.push_back(&evaluation);
  std::stable_sort(
      ranked.begin(), ranked.end(), [](auto a, auto b) { return a->objective < b->objective; });
  std::vector<UnitPoint> starts;
  for (const Evaluation* evaluation : ranked) {
    UnitPoint point = space_.to_unit(evaluation->parameters);
    const bool is_new = std::all_of(starts.begin(), starts.end(), [&](const UnitPoint& other) {
      return distance_between(point, other) > basin_distance;
    });
    if (is_new) starts.push_back(std::move(point));
    if (starts.size() == 2) break;
  }
  return starts;
}

// 6. The interval of each identified parameter.
void Search::find_uncertainty() {
  if (space_.dimension() == 0) return;
  result_.profiles = profile_parameters(
      ensemble_.comparison(),
      space_,
      result_.evaluations,
      [&](const std::vector<ParameterSet>& places) { return search("profile", places); },
      {.bootstrap = bootstrap()});
  surrogate_.emplace(fit_surrogate(ensemble_.comparison(), result_.evaluations, space_));
  result_.surrogate = {
      surrogate_->leave_one_out_error(), surrogate_->value_spread(), surrogate_->roughness()};
  const double allowed = largest_allowed_excess(result_.profiles);
  if (!(allowed > 0.0)) return;
  const Posterior posterior = draw_posterior(
      *surrogate_, surrogate_minimum(*surrogate_, space_.dimension()), allowed, options_.seed);
  for (std::size_t d = 0; d < space_.dimension(); ++d)
    result_.posterior.push_back(marginal(space_, posterior, d));
  result_.posterior_effective_size = posterior.effective_size;
  result_.trade_offs = find_trade_offs(space_, posterior);
}

// 7. The lowest evaluation may be lucky, the surrogate's minimum may be wrong: fresh seeds decide
// between the
// two. The caller scores the winner with further fresh seeds, so that no choice enters the score.
void Search::choose() {
  result_.parameters = space_.from_unit(UnitPoint(space_.dimension(), 0.5));
  if (space_.dimension() > 0) {
    const std::vector<EvaluationPoint> candidates = {
        {space_.from_unit(space_.to_unit(best().parameters)), result_.time_step.fraction},
        {space_.from_unit(surrogate_minimum(*surrogate_, space_.dimension())),
         result_.time_step.fraction}};
    const auto seeds = make_seeds(
        options_.seed, "choice", choice_seeds_per_confirmation * options_.confirmation_seeds);
    const std::vector<Evaluation> evaluations =
        ensemble_.evaluate("confirmation", candidates, seeds, reporter());
    count(evaluations);
    result_.parameters =
        evaluations[evaluations[1].objective <= evaluations[0].objective ? 1 : 0].parameters;
  }
}

// 8. Values, intervals and what must be said of them.
SearchResult Search::finish() {
  for (CalibratedParameter& parameter : result_.calibrated) {
    parameter.value = value_of(result_.parameters, parameter.name);
    for (const Profile& profile : result_.profiles) {
      if (profile.name == parameter.name) give_interval(parameter, profile);
    }
    if (parameter.status == ParameterStatus::not_identified) {
      result_.warnings.push_back(
          fmt::format("{} is not identified: over its full range the objective moves by {:.3g}, "
                      "and other replicates and seeds alone could move it by {:.3g}; it "
                      "is held at its bench value {:.3g}.",
                      parameter.name,
                      parameter.effect,
                      parameter.effect_noise,
                      parameter.bench));
    }
  }
  for (const TradeOff& trade_off : result_.trade_offs)
    result_.warnings.push_back(words_on(trade_off));
  if (result_.failed > 0) {
    result_.warnings.push_back(
        fmt::format("{} of {} simulations did not complete and were scored as a model in which "
                    "nothing moves.",
                    result_.failed,
                    result_.simulations));
  }
  if (result_.retried > 0) {
    result_.warnings.push_back(fmt::format(
        "{} of {} simulations became unstable and were run again at half the time step.",
        result_.retried,
        result_.simulations));
  }
  return std::move(result_);
}

void Search::give_interval(CalibratedParameter& parameter, const Profile& profile) {
  // The value may be the surrogate's minimum rather than the evaluation that the profile is
  // about: the interval holds both.
  parameter.interval = {std::min(profile.interval.lower, parameter.value),
                        std::max(profile.interval.upper, parameter.value)};
  const double near = 0.005 * (parameter.upper_bound - parameter.lower_bound);
  if (parameter.value <= parameter.lower_bound + near ||
      parameter.value >= parameter.upper_bound - near) {
    parameter.status = ParameterStatus::at_bound;
  }
  if (profile.open_above) {
    result_.warnings.push_back(
        fmt::format("{} is not bounded above by these data.", parameter.name));
  }
  if (profile.open_below && parameter.lower_bound > 0.0) {
    result_.warnings.push_back(
        fmt::format("{} is not bounded below by these data.", parameter.name));
  }
}

}  // namespace graintruth::calibrate
