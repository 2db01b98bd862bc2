#include "calibrate/ensemble.h"

#include <fmt/format.h>

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

std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count) {
  std::uint64_t base = mixed(seed);
  for (const char c : purpose) base = mixed(base ^ static_cast<unsigned char>(c));
  std::vector<std::uint64_t> seeds;
  // 53 bits: such a seed survives every tool that reads numbers as doubles.
  for (int i = 0; i < count; ++i)
    seeds.push_back(mixed(base + static_cast<std::uint64_t>(i)) >> 11);
  return seeds;
}

std::vector<Scene> repeated(const Scene& scene, int times) {
  std::vector<Scene> scenes = {scene};
  for (int time = 1; time < times; ++time) {
    Scene again = scene;
    again.spec = [spec = scene.spec, time](
                     const ParameterSet& parameters, double fraction, std::uint64_t seed) {
      return spec(
          parameters, fraction, make_seeds(seed, fmt::format("repeat {}", time), 1).front());
    };
    scenes.push_back(std::move(again));
  }
  return scenes;
}

Ensemble::Ensemble(std::vector<Scene> scenes,
                   Journal& journal,
                   std::shared_ptr<const Comparison> comparison,
                   Executor& executor)
    : scenes_(std::move(scenes)),
      journal_(journal),
      comparison_(std::move(comparison)),
      executor_(executor) {}

SimulatedRun Ensemble::measured(std::size_t scene, EngineRun run) const {
  SimulatedRun measured{.status = run.status,
                        .message = std::move(run.message),
                        .time_step = run.time_step,
                        .seconds = run.seconds};
  if (run.status == RunStatus::completed) measured.channels = scenes_[scene].measure(run.recording);
  return measured;
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
  // 1. What the journal has already
  struct Missing {
    std::size_t point, run;
  };
  const std::size_t runs = scenes_.size() * seeds.size();
  const int total = static_cast<int>(points.size() * runs);
  std::vector<SimulationTask> tasks;
  std::vector<Missing> missing;
  std::mutex mutex;
  int done = 0;
  const auto count = [&](bool from_journal) {
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, total, from_journal);
  };
  for (std::size_t point = 0; point < points.size(); ++point) {
    for (std::size_t run = 0; run < runs; ++run) {
      const Scene& scene = scenes_[run / seeds.size()];
      SimulationSpec spec = scene.spec(
          points[point].parameters, points[point].time_step_fraction, seeds[run % seeds.size()]);
      const std::string fingerprint = fingerprint_of(spec);
      if (auto known = journal_.find(fingerprint)) {
        if (const std::string misfit = comparison_->misfit(*known, run / seeds.size());
            !misfit.empty())
          journal_.refuse(fingerprint, misfit);
        evaluations[point].runs[run] = *std::move(known);
        count(true);
        continue;
      }
      tasks.push_back({scene.engine, std::move(spec)});
      missing.push_back({point, run});
    }
  }
  // 2. What has to be simulated
  executor_.run(tasks, scenes_.front().options, [&](std::size_t task, EngineRun ended) {
    const auto [point, run] = missing[task];
    const std::size_t scene = run / seeds.size();
    const SimulationSpec& spec = tasks[task].spec;
    JournalRow row{.fingerprint = fingerprint_of(spec),
                   .problem = scenes_[scene].problem,
                   .stage = stage,
                   .parameters = spec.parameters,
                   .time_step_fraction = spec.time_step_fraction,
                   .seed = spec.seed,
                   .run = measured(scene, std::move(ended))};
    ++simulated_;
    const RunScore score = comparison_->score_run(row.run, scene);
    row.objective = score.objective;
    row.agreement_percent = score.agreement_percent;
    journal_.add(row);
    evaluations[point].runs[run] = std::move(row.run);
    count(false);
  });
  for (Evaluation& evaluation : evaluations) {
    count_runs(evaluation);
    evaluation.objective = comparison_->objective(evaluation.runs);
  }
  return evaluations;
}

}  // namespace graintruth::calibrate
