#include "calibrate/search/time_step_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace graintruth::calibrate {

namespace {

constexpr std::array<double, 3> shares = {1.0, 0.5, 0.25};  // of the largest fraction

// One step and its half at every place, by as many seeds as it takes.
struct StepTried {
  std::vector<Evaluation> at, at_half;
  std::vector<StepChange> changes;
  std::size_t seeds = 0;

  bool fails() const {
    return std::any_of(at.begin(), at.end(), [](const Evaluation& evaluation) {
      return evaluation.failed + evaluation.retried > 0;
    });
  }
  // Of the places that are not so far from the best that what changes there changes no answer.
  std::vector<StepChange> that_matter() const {
    const Evaluation* best = &at.front();
    for (const std::vector<Evaluation>* all : {&at, &at_half}) {
      for (const Evaluation& evaluation : *all) {
        if (evaluation.objective < best->objective) best = &evaluation;
      }
    }
    std::vector<StepChange> chosen;
    for (std::size_t place = 0; place < changes.size(); ++place) {
      if (!is_hopeless(at[place], *best) || !is_hopeless(at_half[place], *best))
        chosen.push_back(changes[place]);
    }
    return chosen;
  }
  // Of the worst place.
  StepVerdict verdict() const {
    if (fails()) return StepVerdict::changes;
    StepVerdict worst = StepVerdict::resolved;
    for (const StepChange& change : that_matter()) {
      if (change.verdict() == StepVerdict::changes) return StepVerdict::changes;
      if (change.verdict() == StepVerdict::not_resolved) worst = StepVerdict::not_resolved;
    }
    return worst;
  }
  // Whether `most` seeds can be enough where these are not. What is left of chance falls with the
  // root of their number; what nobody knows yet may be little.
  bool is_worth_more(std::size_t most) const {
    const double left = std::sqrt(static_cast<double>(seeds) / static_cast<double>(most));
    if (fails()) return false;
    for (const auto& [change, noise, allowed] : that_matter()) {
      const double half_width = noise.half_width;
      if (std::abs(change) - half_width > allowed) return false;  // it does change
      if (std::isfinite(half_width) && left * half_width > allowed) return false;
    }
    return verdict() != StepVerdict::resolved && seeds < most;
  }
};

StepTried try_step(Ensemble& ensemble,
                   std::span<const ParameterSet> places,
                   double fraction,
                   double largest,
                   std::span<const std::uint64_t> seeds,
                   const std::function<SimulationProgress(double cost)>& progress) {
  std::vector<EvaluationPoint> points;
  for (const double own : {fraction, 0.5 * fraction}) {
    for (const ParameterSet& place : places) points.push_back({place, own});
  }
  const double cost = 1.5 * largest / fraction;  // the mean of the step's and of its half's
  std::vector<Evaluation> evaluations = ensemble.evaluate(
      "time_step", points, seeds, progress ? progress(cost) : SimulationProgress{});
  StepTried tried{.seeds = seeds.size()};
  for (std::size_t place = 0; place < places.size(); ++place) {
    tried.at.push_back(std::move(evaluations[place]));
    tried.at_half.push_back(std::move(evaluations[places.size() + place]));
    tried.changes.push_back(
        step_change(ensemble.comparison(), tried.at.back(), tried.at_half.back()));
  }
  return tried;
}

TimeStepRow row_of(const Evaluation& at, std::size_t seeds) {
  return {.parameters = at.parameters,
          .fraction = at.time_step_fraction,
          .time_step = at.runs.front().time_step,
          .objective = at.objective,
          .seconds = at.seconds,
          .seeds = static_cast<int>(seeds),
          .failed = at.failed + at.retried};
}

}  // namespace

TimeStepChoice choose_time_step(Ensemble& ensemble,
                                std::span<const ParameterSet> places,
                                double largest,
                                std::span<const std::uint64_t> seeds,
                                std::size_t first_seeds,
                                const std::function<SimulationProgress(double cost)>& progress) {
  // 1. From the largest step down to one that its half does not contradict
  std::vector<StepTried> steps;
  for (std::size_t s = 0; s + 1 < shares.size(); ++s) {
    const double fraction = shares[s] * largest;
    std::size_t count = std::min(first_seeds, seeds.size());
    StepTried tried = try_step(ensemble, places, fraction, largest, seeds.first(count), progress);
    while (tried.is_worth_more(seeds.size())) {
      count = std::min(2 * count, seeds.size());
      tried = try_step(ensemble, places, fraction, largest, seeds.first(count), progress);
    }
    steps.push_back(std::move(tried));
    if (steps.back().verdict() != StepVerdict::changes) break;
  }

  // 2. That step; or, if the smallest whose half was tried still changes the answer, its half
  const StepTried& last = steps.back();
  TimeStepChoice choice{.verdict = last.verdict()};
  const std::vector<Evaluation>& chosen =
      choice.verdict == StepVerdict::changes ? last.at_half : last.at;
  choice.fraction = chosen.front().time_step_fraction;
  choice.time_step = chosen.back().runs.front().time_step;
  for (const StepChange& change : last.that_matter())
    choice.discretisation_error = std::max(choice.discretisation_error, std::abs(change.change));

  // 3. What was tried, place by place
  for (std::size_t place = 0; place < places.size(); ++place) {
    std::size_t before = 0;
    for (const StepTried& step : steps) {
      choice.rows.push_back(row_of(step.at[place], std::max(before, step.seeds)));
      choice.rows.back().change = step.changes[place];
      before = step.seeds;
    }
    choice.rows.push_back(row_of(last.at_half[place], last.seeds));
  }
  return choice;
}

double discretisation_error_at(const TimeStepChoice& choice, double fraction) {
  std::map<double, double> error_of = {{0.0, 0.0}};
  for (const TimeStepRow& row : choice.rows) {
    if (!row.change) continue;
    double& error = error_of[row.fraction];
    error = std::max(error, std::abs(row.change->change));
  }
  const auto above = error_of.lower_bound(fraction);
  if (above == error_of.end()) return error_of.rbegin()->second;
  if (above == error_of.begin()) return 0.0;
  const auto below = std::prev(above);
  const double share = (fraction - below->first) / (above->first - below->first);
  return below->second + share * (above->second - below->second);
}

}  // namespace graintruth::calibrate
