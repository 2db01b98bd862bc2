#include "calibrate/ensemble.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

namespace graintruth::calibrate {

namespace {

// Mixes a counter into 64 well spread bits: SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t state) {
  state += 0x9e3779b97f4a7c15ULL;
  state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9ULL;
  state = (state ^ (state >> 27)) * 0x94d049bb133111ebULL;
  return state ^ (state >> 31);
}

double objective_of(const Target& target,
                    std::span<const datasets::Trajectories> tracks,
                    std::span<const int> weights = {}) {
  return objective(target.replicates, target.widths, mean_track(measure(tracks, weights)));
}

// Jackknife standard error from n delete-one values: sqrt((n - 1)/n sum (v_i - mean)^2), Efron and
// Stein (1981).
double jackknife(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  if (values.size() < 2) return 0.0;
  double mean = 0.0;
  for (const double value : values) mean += value / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt((n - 1.0) / n * squares);
}

std::vector<double> delete_one(const Target& target, std::span<const SimulatedRun> runs) {
  const std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  std::vector<double> values;
  std::vector<int> weights(tracks.size(), 1);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    weights[i] = 0;
    values.push_back(objective_of(target, tracks, weights));
    weights[i] = 1;
  }
  return values;
}

}  // namespace

void parallel_for(int count, int jobs, const std::function<void(int)>& task) {
  std::atomic<int> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::jthread> threads;
  for (int thread = 1; thread < std::min(jobs, count); ++thread) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
}

std::vector<datasets::Trajectories> completed_tracks(std::span<const SimulatedRun> runs) {
  std::vector<datasets::Trajectories> tracks;
  for (const SimulatedRun& run : runs) {
    if (run.status == RunStatus::completed) tracks.push_back(run.trajectories);
  }
  return tracks;
}

std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count) {
  std::uint64_t base = mixed(seed);
  for (const char c : purpose) base = mixed(base ^ static_cast<unsigned char>(c));
  std::vector<std::uint64_t> seeds;
  // 53 bits: such a seed survives every tool that reads numbers as doubles.
  for (int i = 0; i < count; ++i)
    seeds.push_back(mixed(base + static_cast<std::uint64_t>(i)) >> 11);
  return seeds;
}

double objective_noise(const Target& target, std::span<const SimulatedRun> runs) {
  return jackknife(delete_one(target, runs));
}

Ensemble::Ensemble(
    Simulator simulator, Journal& journal, std::string problem, Target target, int jobs)
    : simulator_(std::move(simulator)),
      journal_(journal),
      problem_(std::move(problem)),
      target_(std::move(target)),
      jobs_(jobs) {}

SimulatedRun Ensemble::run_once(const std::string& stage,
                                const SimulationRequest& request,
                                bool& from_journal) {
  if (auto known = journal_.find(problem_, request)) {
    from_journal = true;
    return *std::move(known);
  }
  from_journal = false;
  JournalRow row{
      .problem = problem_, .stage = stage, .request = request, .run = simulator_(request)};
  ++simulated_;
  const bool completed = row.run.status == RunStatus::completed;
  row.objective = completed ? objective(target_.replicates, target_.widths, row.run.trajectories)
                            : objective_of_rest(target_.replicates, target_.widths);
  row.agreement_percent =
      completed ? agreement(target_.replicates, row.run.trajectories, Critical::student_t).percent
                : 0.0;
  journal_.add(row);
  return std::move(row.run);
}

void Ensemble::summarise(Evaluation& evaluation) const {
  for (const SimulatedRun& run : evaluation.runs) {
    evaluation.failed += run.status != RunStatus::completed;
    evaluation.seconds += run.seconds;
  }
  const std::vector<datasets::Trajectories> tracks = completed_tracks(evaluation.runs);
  // Half of the runs must have ended well: the mean of a lucky few says nothing about these
  // parameters.
  if (tracks.empty() || 2 * tracks.size() < evaluation.runs.size()) {
    evaluation.objective = objective_of_rest(target_.replicates, target_.widths);
    return;
  }
  evaluation.mean = mean_track(measure(tracks));
  evaluation.objective = objective(target_.replicates, target_.widths, evaluation.mean);
}

std::vector<Evaluation> Ensemble::evaluate(const std::string& stage,
                                           std::span<const EvaluationPoint> points,
                                           std::span<const std::uint64_t> seeds,
                                           const SimulationProgress& progress) {
  std::vector<Evaluation> evaluations;
  for (const EvaluationPoint& point : points) {
    evaluations.push_back({.stage = stage,
                           .parameters = point.parameters,
                           .time_step_fraction = point.time_step_fraction});
    evaluations.back().runs.resize(seeds.size());
  }
  const int total = static_cast<int>(points.size() * seeds.size());
  std::mutex mutex;
  int done = 0;
  parallel_for(total, jobs_, [&](int i) {
    const std::size_t point = static_cast<std::size_t>(i) / seeds.size();
    const std::size_t seed = static_cast<std::size_t>(i) % seeds.size();
    bool from_journal = false;
    evaluations[point].runs[seed] =
        run_once(stage,
                 {points[point].parameters, points[point].time_step_fraction, seeds[seed]},
                 from_journal);
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, total, from_journal);
  });
  for (Evaluation& evaluation : evaluations) summarise(evaluation);
  return evaluations;
}

}  // namespace graintruth::calibrate
