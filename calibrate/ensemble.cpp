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

std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count) {
  std::uint64_t base = mixed(seed);
  for (const char c : purpose) base = mixed(base ^ static_cast<unsigned char>(c));
  std::vector<std::uint64_t> seeds;
  // 53 bits: such a seed survives every tool that reads numbers as doubles.
  for (int i = 0; i < count; ++i)
    seeds.push_back(mixed(base + static_cast<std::uint64_t>(i)) >> 11);
  return seeds;
}

Ensemble::Ensemble(std::vector<Scene> scenes,
                   Journal& journal,
                   std::shared_ptr<const Comparison> comparison,
                   int jobs)
    : scenes_(std::move(scenes)),
      journal_(journal),
      comparison_(std::move(comparison)),
      jobs_(jobs) {}

SimulatedRun Ensemble::simulate(const Simulator& simulator, const SimulationRequest& request) {
  SimulatedRun run = simulator(request);
  if (run.status != RunStatus::unstable) return run;
  SimulationRequest finer = request;
  finer.time_step_fraction = 0.5 * request.time_step_fraction;
  SimulatedRun again = simulator(finer);
  if (again.status != RunStatus::completed) return run;
  again.message =
      "unstable at the time step asked for (" + run.message + "), completed at half of it";
  again.seconds += run.seconds;
  return again;
}

SimulatedRun Ensemble::run_once(const std::string& stage,
                                std::size_t scene,
                                const SimulationRequest& request,
                                bool& from_journal) {
  const auto& [problem, simulator] = scenes_[scene];
  if (auto known = journal_.find(problem, request)) {
    from_journal = true;
    return *std::move(known);
  }
  from_journal = false;
  JournalRow row{
      .problem = problem, .stage = stage, .request = request, .run = simulate(simulator, request)};
  ++simulated_;
  const RunScore score = comparison_->score_run(row.run, scene);
  row.objective = score.objective;
  row.agreement_percent = score.agreement_percent;
  journal_.add(row);
  return std::move(row.run);
}

void Ensemble::summarise(Evaluation& evaluation) const {
  count_runs(evaluation);
  evaluation.objective = comparison_->objective(evaluation.runs);
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
    evaluations.back().runs.resize(scenes_.size() * seeds.size());
  }
  const std::size_t runs = scenes_.size() * seeds.size();
  const int total = static_cast<int>(points.size() * runs);
  std::mutex mutex;
  int done = 0;
  parallel_for(total, jobs_, [&](int i) {
    const std::size_t point = static_cast<std::size_t>(i) / runs;
    const std::size_t run = static_cast<std::size_t>(i) % runs;
    const EvaluationPoint& at = points[point];
    bool from_journal = false;
    evaluations[point].runs[run] =
        run_once(stage,
                 run / seeds.size(),
                 {at.parameters, at.time_step_fraction, seeds[run % seeds.size()]},
                 from_journal);
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, total, from_journal);
  });
  for (Evaluation& evaluation : evaluations) summarise(evaluation);
  return evaluations;
}

}  // namespace graintruth::calibrate
