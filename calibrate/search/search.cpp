#include "calibrate/search/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/knowledge/sensitivity.h"
#include "calibrate/search/choice.h"
#include "calibrate/search/proposals.h"
#include "calibrate/search/reach.h"
#include "datasets/parameters/parameter.h"

namespace graintruth::calibrate {

namespace {

// Shares of the budget; the finer local search has the rest.
constexpr double design_share = 0.2;
constexpr double proposal_share = 0.38;  // the emulator's
constexpr double profile_share = 0.4;    // effects and ends of the intervals: no more than this
constexpr double prior_share = 0.3;      // what is kept until the prior counts, where there is one
constexpr int least_design = 8;          // evaluations
constexpr int proposed_at_once = 2;
constexpr std::size_t proposal_centres = 3;
constexpr int proposal_crowd = 8;         // evaluations, see Aim
constexpr double centre_distance = 0.02;  // of a range; nearer places are one centre
constexpr double polish_step = 0.03;      // of each range; first step of the local search
constexpr int stall_evaluations = 12;     // without gain end a local search
constexpr int gate_places = 2;
constexpr double gate_cost = 1.0 + 2.0 + 4.0;  // of the step, its half and its quarter at one place
constexpr double candidate_distance = 0.01;    // of a range; nearer ones would tell the same
// The emulator's minimum, the surrogate's, and its posterior's mean
constexpr int other_candidates = 3;

}  // namespace

int choice_simulations(const CalibrationOptions& options) {
  // Candidates with half of the seeds, the better two with the rest; two more with all of them
  // where something is held at its bench value
  const int halves = options.choice_candidates + other_candidates + 2 + 2 * 2;
  return halves * options.confirmation_seeds;
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
      space_(experiment.tuned, datasets::bench_parameters(experiment)),
      prior_(experiment.tuned),
      budget_(options.budget) {
  if (prior_.is_stated()) budget_ -= share_of_budget(prior_share);
  for (const auto& [name, value] : datasets::bench_parameters(experiment)) {
    const datasets::BenchValue bench = datasets::bench_value(experiment, name);
    CalibratedParameter parameter{.name = name,
                                  .value = bench.value,
                                  .bench = bench.value,
                                  .bench_uncertainty = bench.standard_uncertainty};
    for (const datasets::TunedParameter& tuned : experiment.tuned) {
      if (tuned.name != name) continue;
      parameter.lower_bound = tuned.lower;
      parameter.upper_bound = tuned.upper;
      parameter.prior = tuned.prior;
    }
    result_.calibrated.push_back(std::move(parameter));
  }
}

void Search::run() {
  timed("time step", [&] { choose_step(); });
  timed("design", [&] { explore(); });
  timed("self-test", [&] { test_itself(); });
  const bool is_joint = experiment_.time_step_rule == datasets::TimeStepRule::joint;
  timed("proposals", [&] {
    // The local search along one more axis, the time step's, needs its own share
    follow_emulator(
        is_joint ? 0.5 * proposal_share : proposal_share, kept_for_intervals(), proposal_crowd);
  });
  timed("polish", [&] {
    if (is_joint) {
      polish_with_time_step();
    } else {
      polish(kept_for_intervals());
    }
  });
  timed("effects", [&] { find_effects(); });
  timed("uncertainty", [&] { find_uncertainty(); });
  if (prior_.is_stated()) timed("prior", [&] { bring_in_prior(); });
  timed("last proposals", [&] { follow_emulator(1.0, 0); });
  timed("posterior", [&] { learn_landscape(); });
  timed("choice", [&] { choose(); });
  say_that_time_was_up();
}

// A clock is no part of the experiment: without it the same command comes farther, or on another
// machine.
void Search::say_that_time_was_up() {
  const auto evaluations = static_cast<int>(result_.evaluations.size());
  if (!is_time_up() || evaluations >= options_.budget || space_.dimension() == 0) return;
  result_.warnings.push_back(fmt::format(
      "The time limit of {:.4g} s ended the search after {} of {} evaluations, so that another "
      "machine may find other parameters. Run the same command without it to go on from here.",
      options_.time_limit,
      evaluations,
      options_.budget));
}

void Search::timed(const char* name, const std::function<void()>& stage) {
  const auto start = std::chrono::steady_clock::now();
  stage_ = name;
  stage();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  result_.stages.push_back({name, taken.count()});
}

// Expected cost in simulations at the largest time step: the gate's smaller steps weigh more,
// all of which are needed where the largest does change the answer.
double expected_cost(std::size_t scenes, const CalibrationOptions& options) {
  const double gate = gate_places * gate_cost * options.gate_seeds;
  const double search = options.budget * options.search_seeds + choice_simulations(options);
  return static_cast<double>(scenes) * (gate + search);
}

// `weight` is the mean cost of a simulation of the batch.
SimulationProgress Search::reporter(double weight) {
  const double expected = expected_cost(ensemble_.scenes(), options_) + later_simulations_;
  return [this, weight, expected, before = cost_](int done, int, bool) {
    cost_ = before + weight * done;
    if (!options_.progress) return;
    options_.progress({.stage = stage_,
                       .evaluations = static_cast<int>(result_.evaluations.size()),
                       .budget = options_.budget,
                       .share = std::min(1.0, cost_ / expected),
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
        fmt::format("{} of {} simulations failed ({}); look at walls and starting places in the "
                    "pictures of 'graintruth check', or lower the bounds.",
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
  return search(stage, points);
}

std::vector<Evaluation> Search::search(const char* stage,
                                       const std::vector<EvaluationPoint>& points) {
  std::vector<Evaluation> evaluations =
      ensemble_.evaluate(stage, points, search_seeds_, reporter());
  count(evaluations);
  result_.evaluations.insert(result_.evaluations.end(), evaluations.begin(), evaluations.end());
  return evaluations;
}

const Evaluation& Search::best() const { return best_of(result_.evaluations, prior_); }

int Search::share_of_budget(double share) const {
  return static_cast<int>(std::lround(share * budget_));
}

int Search::kept_for_intervals() const {
  const int wanted = (1 + ProfileOptions{}.rounds) * 2 * static_cast<int>(space_.dimension());
  return std::min(wanted, share_of_budget(profile_share));
}

bool Search::is_time_up() const {
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started_;
  return options_.time_limit > 0.0 && taken.count() > options_.time_limit;
}

// What ended a search that did not find all that it sought.
std::string Search::words_on_limit() const {
  return is_time_up() ? fmt::format("The time limit of {:.4g} s", options_.time_limit)
                      : fmt::format("The budget of {} evaluations", options_.budget);
}

int Search::budget_left() const {
  if (is_time_up()) return 0;
  return budget_ - static_cast<int>(result_.evaluations.size());
}

// What must be said of a step that is not resolved.
datasets::Warning words_on_step(const TimeStepChoice& choice) {
  if (choice.verdict == StepVerdict::changes) {
    return datasets::first_line(
        fmt::format("The objective still changes by {:.3g} at the smallest time step tried "
                    "(fraction {:.3g}): the result depends on the time step.",
                    choice.discretisation_error,
                    choice.fraction),
        "the time step is not resolved, so the result depends on it",
        "Look at the time-step study; a lower elastic modulus may resolve it");
  }
  // The place that tells least
  const TimeStepRow* worst = nullptr;
  for (const TimeStepRow& row : choice.rows) {
    if (!row.change || row.change->verdict() != StepVerdict::not_resolved) continue;
    const auto beyond = [](const StepChange& change) {
      return std::abs(change.change) + change.noise.half_width - change.allowed;
    };
    if (worst == nullptr || beyond(*row.change) > beyond(*worst->change)) worst = &row;
  }
  const StepChange change = worst != nullptr ? *worst->change : StepChange{};
  return datasets::first_line(
      fmt::format(
          "The time step is not resolved: runs scatter so much that {} a place do not tell "
          "what half the step does. It changes the objective by {:.2g}, give or take {:.2g}; "
          "{:.2g} in all would be little beside what other replicates could change.",
          worst != nullptr && worst->seeds == 1
              ? "runs of one seed"
              : fmt::format("{} seeds", worst != nullptr ? worst->seeds : 0),
          change.change,
          change.noise.half_width,
          change.allowed),
      "runs scatter too much to tell whether the time step matters",
      "Compare what scatters less from run to run, or check the result at half the time step");
}

// 1. The time step, at the centre of the box and half way from there to its lower corner, where
// particles move more.
void Search::choose_step() {
  std::vector<ParameterSet> places;
  for (const double level : {0.5, 0.25})
    places.push_back(space_.from_unit(UnitPoint(space_.dimension(), level)));
  // Those of the search are the first of these.
  const auto seeds = make_seeds(options_.seed, "search", options_.most_gate_seeds);
  result_.time_step = choose_time_step(ensemble_,
                                       places,
                                       options_.largest_time_step_fraction,
                                       seeds,
                                       static_cast<std::size_t>(options_.gate_seeds),
                                       [this](double cost) { return reporter(cost); });
  for (const TimeStepRow& row : result_.time_step.rows) {
    result_.simulations += static_cast<int>(ensemble_.scenes()) * row.seeds;
    result_.failed += row.failed;
  }
  if (result_.time_step.verdict != StepVerdict::resolved)
    warn_early(words_on_step(result_.time_step));
}

// 2. A low-discrepancy design: above some friction particles jam, so the objective is not
// unimodal and a local search
//    alone would end where it began.
void Search::explore() {
  if (space_.dimension() == 0) return;
  const int points = std::max(least_design, share_of_budget(design_share));
  std::vector<ParameterSet> places;
  for (const UnitPoint& point : low_discrepancy_points(points, space_.dimension(), options_.seed)) {
    places.push_back(space_.from_unit(point));
  }
  search("design", places);
}

// 3. On the design: whether known truths are found again, and whether the measured lies within
// reach.
void Search::test_itself() {
  if (space_.dimension() == 0) return;
  result_.self_test = self_test(ensemble_.comparison(), result_.evaluations);
  if (const auto& test = result_.self_test; test && 2 * test->found < test->truths) {
    warn_early(datasets::first_line(
        fmt::format("Self-test: only {1} of {0} known parameter sets were found again. Chance "
                    "hides the effect of the parameters in this experiment.",
                    test->truths,
                    test->found),
        fmt::format("the self-test found only {} of {} known parameter sets again",
                    test->found,
                    test->truths),
        "Measure more, or where the parameters matter more"));
  }
  check_reach();
}

// Prior and data in conflict: no parameters between the bounds give what was measured.
void Search::check_reach() {
  constexpr double worth_a_word = 0.1;
  result_.out_of_reach = share_out_of_reach(ensemble_.comparison(), result_.evaluations);
  if (!(result_.out_of_reach > worth_a_word)) return;
  const double percent = 100.0 * result_.out_of_reach;
  warn_early(datasets::first_line(
      fmt::format("{:.0f} % of the measured values lie outside everything that the model gave "
                  "between the bounds. The rig, the particle or the bounds are not those of the "
                  "experiment.",
                  percent),
      fmt::format("no parameters within the bounds give {:.0f} % of the measured values", percent),
      "Check rig, particle and bounds in the experiment file"));
}

// What the user should know before more is spent.
void Search::warn_early(datasets::Warning warning) {
  if (options_.notice) options_.notice(warning.text);
  result_.warnings.push_back(std::move(warning));
}

// 4. What an emulator of all evaluations so far proposes, batch after batch: between neighbouring
// valleys, of which only one is right, it goes where most may be gained; with a `crowd`, into none
// of them for ever.
void Search::follow_emulator(double share, int kept, int crowd) {
  if (space_.dimension() == 0) return;
  const int last = static_cast<int>(result_.evaluations.size()) + share_of_budget(share);
  for (std::uint64_t round = 0; static_cast<int>(result_.evaluations.size()) < last; ++round) {
    const int count = std::min({proposed_at_once,
                                last - static_cast<int>(result_.evaluations.size()),
                                budget_left() - kept});
    if (count < 1) return;
    const Emulator& emulator = learn_emulator();
    if (!emulator.knows_anything()) return;
    const Aim aim{lowest_predicted(),
                  noise_of_lowest(ensemble_.comparison(), result_.evaluations),
                  [&](const UnitPoint& place) { return prior_.penalty(space_.from_unit(place)); },
                  crowd};
    std::vector<ParameterSet> places;
    for (const UnitPoint& place : propose(emulator,
                                          aim,
                                          lowest_places(proposal_centres, centre_distance),
                                          count,
                                          options_.seed + round))
      places.push_back(space_.from_unit(place));
    if (places.empty()) return;
    search("proposals", places);
  }
}

// Of all places evaluated so far. The lowest evaluation is lucky, and the numbers that the emulator
// predicts have less of the seeds' noise in them, so that their loss is lower: against what was
// simulated every place of a well-known valley promises to be better.
double Search::lowest_predicted() const {
  std::vector<UnitPoint> places;
  for (const Evaluation& evaluation : result_.evaluations)
    places.push_back(space_.to_unit(evaluation.parameters));
  const std::vector<double> totals = landscape_of(*emulator_, space_, prior_)(places);
  return *std::min_element(totals.begin(), totals.end());
}

// Of all evaluations so far.
const Emulator& Search::learn_emulator() {
  emulator_ = Emulator(
      ensemble_.comparison(), result_.evaluations, space_, emulator_ ? &*emulator_ : nullptr);
  return *emulator_;
}

std::vector<Evaluation> Search::compatible_evaluations(std::size_t count) const {
  const PooledChance chance = pool_chance(ensemble_.comparison(), result_.evaluations, 0.0);
  const std::vector<Evaluation> candidates =
      compatible_with(ensemble_.comparison(), best(), result_.evaluations, chance, prior_);
  std::vector<Evaluation> chosen = {best()};
  while (chosen.size() < count) {
    const Evaluation* farthest = nullptr;
    double distance = 0.0;
    for (const Evaluation& candidate : candidates) {
      double nearest = 1.0;
      for (const Evaluation& other : chosen) {
        nearest = std::min(nearest,
                           chebyshev_distance(space_.to_unit(candidate.parameters),
                                              space_.to_unit(other.parameters)));
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

CalibratedParameter& Search::calibrated(std::string_view name) {
  for (CalibratedParameter& parameter : result_.calibrated) {
    if (parameter.name == name) return parameter;
  }
  throw std::logic_error("no such parameter");
}

OptimiserOptions Search::local_search(double step, int budget) const {
  return {.max_evaluations = budget,
          .initial_step = step,
          .objective_tolerance = 0.5 * ensemble_.comparison().noise(best().runs),
          .stall_evaluations = stall_evaluations};
}

// 5. A local search from the best place: an emulator blurs what is finer than the spacing of its
// points. `kept` evaluations are left to others.
void Search::polish(int kept) {
  if (space_.dimension() == 0) {
    result_.stop_reason = "nothing to tune";
    return;
  }
  const int budget = budget_left() - kept;
  if (budget < 1) {
    if (result_.stop_reason.empty())
      result_.stop_reason = "the budget left nothing for a local search";
    return;
  }
  const auto objective = [&](const UnitPoint& point) {
    return prior_.total(search("polish", {space_.from_unit(point)}).front());
  };
  result_.stop_reason =
      minimise(objective, space_.to_unit(best().parameters), local_search(polish_step, budget))
          .stop_reason;
}

// The same with the time step as one more axis, logarithmic from the smallest that the gate tried
// to the largest that is stable. What a step may add to the objective is added to it, so that a
// coarse step cannot win by its error alone; that of the winner is kept from here on.
void Search::polish_with_time_step() {
  constexpr double step = 0.1;  // of each range; first one
  const int budget = budget_left() - kept_for_intervals();
  if (space_.dimension() == 0 || budget < 1) return;
  double smallest = result_.time_step.fraction;
  for (const TimeStepRow& row : result_.time_step.rows) smallest = std::min(smallest, row.fraction);
  const double span = std::log(options_.largest_time_step_fraction / smallest);
  EvaluationPoint winner{best().parameters, result_.time_step.fraction};
  double lowest = std::numeric_limits<double>::infinity();
  double seconds = result_.time_step.time_step;
  const auto objective = [&](const UnitPoint& point) {
    const double fraction = smallest * std::exp(span * point.back());
    const EvaluationPoint at{space_.from_unit({point.begin(), point.end() - 1}), fraction};
    const Evaluation evaluation = search("polish", std::vector<EvaluationPoint>{at}).front();
    const double penalised =
        evaluation.objective + discretisation_error_at(result_.time_step, fraction);
    if (penalised < lowest) {
      lowest = penalised;
      winner = at;
      seconds = evaluation.runs.front().time_step;
    }
    return penalised;
  };
  UnitPoint start = space_.to_unit(best().parameters);
  start.push_back(span > 0.0 ? std::log(result_.time_step.fraction / smallest) / span : 0.0);
  result_.stop_reason = minimise(objective, start, local_search(step, budget)).stop_reason;
  result_.time_step.joint = true;
  result_.time_step.fraction = winner.time_step_fraction;
  result_.time_step.time_step = seconds;
  result_.time_step.discretisation_error =
      discretisation_error_at(result_.time_step, winner.time_step_fraction);
  result_.warnings.push_back(
      "The time step was searched together with the parameters, as time_step = \"joint\" asks. A "
      "coarse step acts like damping, so each can make up for the other. Do not use these "
      "parameters at another time step.");
}

std::vector<UnitPoint> Search::lowest_places(std::size_t count, double distance) const {
  std::vector<UnitPoint> places;
  for (const Evaluation* evaluation : by_objective(result_.evaluations, prior_)) {
    UnitPoint point = space_.to_unit(evaluation->parameters);
    const bool is_new = std::all_of(places.begin(), places.end(), [&](const UnitPoint& other) {
      return chebyshev_distance(point, other) > distance;
    });
    if (is_new) places.push_back(std::move(point));
    if (places.size() == count) break;
  }
  return places;
}

// 6. What each parameter does on its own: from the best place to either end of its range. What
// shows no more than other replicates and seeds could explain, the data do not identify.
void Search::find_effects() {
  if (space_.dimension() == 0) return;
  const Evaluation base = best();
  const PooledChance chance = pool_chance(ensemble_.comparison(), result_.evaluations, 0.0);
  for (const datasets::TunedParameter& tuned : space_.tuned()) {
    CalibratedParameter& parameter = calibrated(tuned.name);
    std::vector<ParameterSet> places(2, base.parameters);
    places[0].set(tuned.name, tuned.lower);
    places[1].set(tuned.name, tuned.upper);
    bool shows = false;
    for (const Evaluation& tried : search("effects", places)) {
      const double size = std::abs(tried.objective - base.objective);
      const double noise = ensemble_.comparison().half_width_of_difference(base, tried, chance);
      shows = shows || size > noise;
      if (size < parameter.effect) continue;
      parameter.effect = size;
      parameter.effect_noise = noise;
    }
    parameter.shows_effect = shows;
    parameter.status = shows ? ParameterStatus::tuned : ParameterStatus::not_identified;
  }
}

// Of the parameters that show an effect.
std::vector<Profile> Search::find_profiles() {
  std::vector<std::string> unseen;
  for (const CalibratedParameter& parameter : result_.calibrated) {
    if (!parameter.shows_effect) unseen.push_back(parameter.name);
  }
  return profile_parameters(
      ensemble_.comparison(),
      space_,
      result_.evaluations,
      [&](const std::vector<ParameterSet>& places) { return search("profile", places); },
      {.prior = prior_, .left_out = unseen, .max_evaluations = std::max(0, budget_left())});
}

// 7. The interval that the data give to each parameter.
void Search::find_uncertainty() {
  if (space_.dimension() == 0) return;
  result_.profiles = find_profiles();
  for (const Profile& profile : result_.profiles) {
    CalibratedParameter& parameter = calibrated(profile.name);
    parameter.lower_end = profile.below;
    parameter.upper_end = profile.above;
    // Where every value fits once the others follow, the data do not identify it either. Where
    // the search ended before that was shown, they say nothing.
    if (profile.below == EndKind::open && profile.above == EndKind::open) {
      parameter.status = ParameterStatus::not_identified;
    } else if (profile.has_an_end()) {
      parameter.data_alone = {profile.best, profile.interval, profile.below, profile.above};
    }
  }
}

// What the data allow at 95 %: the most that was allowed to any compatible evaluation. Where
// nothing but the best is compatible, as the effects tell: on a parabola t S grows with the root of
// the excess, and is twice what is allowed where an interval ends, so that (t S)^2 / (4 excess) is
// allowed there.
double Search::allowed_by_data() const {
  double allowed = largest_allowed_excess(ensemble_.comparison(), space_, result_.evaluations);
  if (allowed > 0.0) return allowed;
  for (const CalibratedParameter& parameter : result_.calibrated) {
    const double noise = parameter.effect_noise;
    if (parameter.effect > 0.0)
      allowed = std::max(allowed, noise * noise / (4.0 * parameter.effect));
  }
  return allowed;
}

// 8. What the data alone say is known by now, and stands as it is; from here on the prior counts:
// proposals, a local search and intervals once more.
void Search::bring_in_prior() {
  constexpr double share = 0.05;  // of the budget, for proposals and for the local search
  if (space_.dimension() == 0) return;
  budget_ = options_.budget;
  prior_.weigh(allowed_by_data());
  result_.prior_allowed_excess = prior_.allowed();
  for (const CalibratedParameter& parameter : result_.calibrated) {
    if (!is_in_conflict(parameter)) continue;
    warn_early(datasets::first_line(words_on_conflict(parameter),
                                    fmt::format("data and prior contradict each other on the {}",
                                                datasets::parameter_named(parameter.name).phrase()),
                                    "Check the prior, or calibrate without it"));
  }
  follow_emulator(share, 0);
  polish(std::max(0, budget_left() - share_of_budget(share)));
  result_.profiles = find_profiles();
}

// 9. A surrogate of all evaluations: sensitivities and trade-offs of the data alone, and the
// posterior.
void Search::learn_landscape() {
  if (space_.dimension() == 0) return;
  const std::size_t dimension = space_.dimension();
  Surrogate of_data = fit_surrogate(ensemble_.comparison(), result_.evaluations, space_);
  result_.surrogate = {of_data.leave_one_out_error(), of_data.value_spread(), of_data.roughness()};
  const std::vector<double> indices = total_sensitivities(of_data, dimension);
  for (std::size_t d = 0; d < indices.size(); ++d)
    calibrated(space_.tuned()[d].name).sobol_total = indices[d];
  const double allowed =
      prior_.is_weighed()
          ? prior_.allowed()
          : largest_allowed_excess(ensemble_.comparison(), space_, result_.evaluations);
  const auto draw = [&](const Surrogate& surrogate, const UnitPoint& start) {
    return draw_posterior(surrogate, start, allowed, options_.seed);
  };
  if (prior_.is_weighed()) {
    const Posterior posterior = draw(of_data, minimum_of(landscape_of(of_data), dimension));
    result_.trade_offs = find_trade_offs(space_, posterior);
  }
  surrogate_.emplace(with_prior(std::move(of_data), space_, prior_));
  surrogate_minimum_ = minimum_of(landscape_of(*surrogate_), dimension);
  if (!(allowed > 0.0)) return;
  const Posterior posterior = draw(*surrogate_, surrogate_minimum_);
  for (std::size_t d = 0; d < dimension; ++d)
    result_.posterior.push_back(marginal_of(posterior, space_, d));
  posterior_mean_ = mean_of(posterior);
  result_.posterior_effective_size = posterior.effective_size;
  if (!prior_.is_weighed()) result_.trade_offs = find_trade_offs(space_, posterior);
}

// Where a parameter that the data do not identify is put if that costs nothing: at its bench value,
// or, if it shows no effect, at its prior's mean. Nowhere where priors give it an interval.
std::optional<double> Search::held_value(const CalibratedParameter& parameter) const {
  if (parameter.status != ParameterStatus::not_identified && !is_unfinished(parameter))
    return std::nullopt;
  if (!parameter.shows_effect && parameter.prior)
    return std::clamp(parameter.prior->value, parameter.lower_bound, parameter.upper_bound);
  if (const Profile* profile = profile_of(parameter);
      profile != nullptr && prior_.is_weighed() && profile->has_an_end())
    return std::nullopt;
  return parameter.bench;
}

// 10. The lowest evaluation may be lucky, the surrogate's minimum may be wrong: fresh seeds decide
// between the few best, and twice as many between the two that are left. Parameters that are not
// identified stay at their bench values where that costs no more than seeds explain. The caller
// scores the winner with further fresh seeds, so that no choice enters the score.
void Search::choose() {
  result_.parameters = space_.from_unit(UnitPoint(space_.dimension(), 0.5));
  if (space_.dimension() == 0) return;
  const auto fraction = result_.time_step.fraction;
  const auto seeds = make_seeds(options_.seed, "choice", 2 * options_.confirmation_seeds);
  const auto half = std::span(seeds).first(seeds.size() / 2);
  const Choice choice(ensemble_.comparison(), prior_, ensemble_.scenes());
  const auto compare = [&](const std::vector<EvaluationPoint>& points,
                           std::span<const std::uint64_t> with) {
    std::vector<Evaluation> evaluations =
        ensemble_.evaluate("confirmation", points, with, reporter());
    count(evaluations);
    choice.sort(evaluations);
    return evaluations;
  };

  // 1. The best evaluations, the emulator's and the surrogate's minima, and the middle of what is
  // plausible: where the landscape is rough the lowest place is a lucky one
  std::vector<EvaluationPoint> candidates;
  for (const UnitPoint& place :
       lowest_places(static_cast<std::size_t>(options_.choice_candidates), candidate_distance))
    candidates.push_back({space_.from_unit(place), fraction});
  const Emulator& emulator = learn_emulator();
  if (emulator.knows_anything()) {
    result_.emulator = {emulator.leave_one_out_error(), emulator.value_spread()};
    const UnitPoint lowest = minimum_of(landscape_of(emulator, space_, prior_), space_.dimension());
    candidates.push_back({space_.from_unit(lowest), fraction});
  }
  candidates.push_back({space_.from_unit(surrogate_minimum_), fraction});
  if (!posterior_mean_.empty()) candidates.push_back({space_.from_unit(posterior_mean_), fraction});
  const std::vector<Evaluation> first = compare(candidates, half);
  const std::vector<Evaluation> last =
      compare({{first[0].parameters, fraction}, {first[1].parameters, fraction}}, seeds);
  const Evaluation& winner = last.front();
  result_.parameters = winner.parameters;

  // 2. What is not identified at its bench value, the others at their best for it
  std::vector<HeldCoordinate> held;
  for (std::size_t d = 0; d < space_.dimension(); ++d) {
    const std::string& name = space_.tuned()[d].name;
    ParameterSet at_value = winner.parameters;
    const auto value = held_value(calibrated(name));
    if (!value) continue;
    at_value.set(name, *value);
    held.push_back({d, space_.to_unit(at_value)[d]});
  }
  if (held.empty()) return;
  UnitPoint as_found = space_.to_unit(winner.parameters);
  for (const HeldCoordinate& coordinate : held) as_found[coordinate.dimension] = coordinate.value;
  const UnitPoint optimised =
      emulator.knows_anything()
          ? minimum_of(landscape_of(emulator, space_, prior_), space_.dimension(), held)
          : minimum_of(landscape_of(*surrogate_), space_.dimension(), held);
  const std::vector<Evaluation> at_bench = compare(
      {{space_.from_unit(as_found), fraction}, {space_.from_unit(optimised), fraction}}, seeds);
  if (choice.is_as_good(at_bench.front(), winner)) result_.parameters = at_bench.front().parameters;
}

datasets::Warning words_on_failed(int failed, int simulations, std::string text) {
  return datasets::first_line(std::move(text),
                              fmt::format("{} of {} simulations failed", failed, simulations),
                              "See journal.csv for why they failed");
}

// 11. Values, intervals and what must be said of them.
SearchResult Search::finish() {
  result_.objective_form = ensemble_.comparison().form();
  result_.by_objective = best_by_each_objective(ensemble_.comparison(), result_.evaluations);
  for (CalibratedParameter& parameter : result_.calibrated) {
    parameter.value = value_of(result_.parameters, parameter.name);
    give_interval(parameter);
    say_what_is_open(parameter);
    if (parameter.status == ParameterStatus::not_identified)
      result_.warnings.push_back(words_on_unidentified(parameter, result_.calibrated));
    const std::string dominance = words_on_dominance(parameter);
    if (!dominance.empty()) result_.warnings.push_back(dominance);
  }
  for (const TradeOff& trade_off : result_.trade_offs) {
    std::string sentence = words_on(trade_off);
    for (const std::string& name : {trade_off.first, trade_off.second}) {
      if (calibrated(name).prior) sentence += fmt::format(" Here the prior of {} does.", name);
    }
    result_.warnings.push_back(std::move(sentence));
  }
  for (const OpenPair& pair : find_open_pairs(result_.calibrated, result_.trade_offs))
    result_.warnings.push_back(words_on(pair));
  if (result_.failed > 0) {
    result_.warnings.push_back(words_on_failed(
        result_.failed,
        result_.simulations,
        fmt::format("{} of {} simulations did not complete and were scored as a model in which "
                    "nothing moves.",
                    result_.failed,
                    result_.simulations)));
  }
  if (result_.retried > 0) {
    result_.warnings.push_back(fmt::format(
        "{} of {} simulations became unstable and were run again at half the time step.",
        result_.retried,
        result_.simulations));
  }
  return std::move(result_);
}

const Profile* Search::profile_of(const CalibratedParameter& parameter) const {
  for (const Profile& profile : result_.profiles) {
    if (profile.name == parameter.name) return &profile;
  }
  return nullptr;
}

void Search::give_interval(CalibratedParameter& parameter) {
  const bool is_identified = parameter.status == ParameterStatus::tuned;
  if (const Profile* profile = profile_of(parameter)) {
    if (is_identified || (prior_.is_weighed() && profile->has_an_end())) {
      parameter.interval = profile->interval;
      parameter.lower_end = profile->below;
      parameter.upper_end = profile->above;
    }
    // What the budget left open beside the prior ends where it ends without
    if (const auto& data = parameter.data_alone) {
      if (profile->below != EndKind::found) {
        parameter.interval->lower = data->interval.lower;
        parameter.lower_end = data->below;
      }
      if (profile->above != EndKind::found) {
        parameter.interval->upper = data->interval.upper;
        parameter.upper_end = data->above;
      }
    }
  } else if (parameter.status == ParameterStatus::not_identified && parameter.prior) {
    parameter.interval = prior_interval(parameter);
    parameter.lower_end = parameter.upper_end = EndKind::found;
  }
  if (!parameter.interval) return;
  // The value may be the surrogate's minimum rather than the evaluation that the profile is
  // about: the interval holds both.
  parameter.interval = {std::min(parameter.interval->lower, parameter.value),
                        std::max(parameter.interval->upper, parameter.value)};
  const double near = 0.005 * (parameter.upper_bound - parameter.lower_bound);
  if (is_identified && !is_unfinished(parameter) &&
      (parameter.value <= parameter.lower_bound + near ||
       parameter.value >= parameter.upper_bound - near))
    parameter.status = ParameterStatus::at_bound;
  if (!prior_.is_stated() && parameter.data_alone) {
    parameter.data_alone->value = parameter.value;
    parameter.data_alone->interval = *parameter.interval;
  }
}

void Search::say_what_is_open(const CalibratedParameter& parameter) {
  const std::string unfinished = words_on_search_end(parameter, words_on_limit());
  if (!unfinished.empty()) result_.warnings.push_back(unfinished);
  if (!parameter.data_alone) return;
  if (parameter.data_alone->above == EndKind::open) {
    result_.warnings.push_back(
        fmt::format("{} is not bounded above by these data.", parameter.name));
  }
  if (parameter.data_alone->below == EndKind::open && parameter.lower_bound > 0.0) {
    result_.warnings.push_back(
        fmt::format("{} is not bounded below by these data.", parameter.name));
  }
}

}  // namespace graintruth::calibrate
