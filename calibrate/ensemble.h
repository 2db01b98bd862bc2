// Many simulations at once: every (parameters, seed) pair is looked up in the journal or simulated,
// with the same outcome wherever it runs.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/comparison.h"
#include "calibrate/executors/executor.h"
#include "calibrate/journal.h"

namespace graintruth::calibrate {

struct EvaluationPoint {
  ParameterSet parameters;
  double time_step_fraction = 0.0;
};

// Called after each simulation, one at a time: simulations done in this batch, batch size, whether
// it came from the journal.
using SimulationProgress = std::function<void(int done, int total, bool from_journal)>;

// One simulated situation: what is simulated for given parameters, and what is measured of it.
struct Scene {
  std::string problem;  // fingerprint of everything but parameters, time step and seed
  const Engine* engine = nullptr;
  EngineOptions options;
  std::function<SimulationSpec(
      const ParameterSet& parameters, double time_step_fraction, std::uint64_t seed)>
      spec;
  std::function<std::vector<Channel>(const datasets::Recording& recording)> measure;
};

// The scene `times` over, each time with seeds of its own.
std::vector<Scene> repeated(const Scene& scene, int times);

class Ensemble {
 public:
  // An evaluation simulates every scene with every seed.
  Ensemble(std::vector<Scene> scenes,
           Journal& journal,
           std::shared_ptr<const Comparison> comparison,
           Executor& executor);

  // Evaluates all points with the same seeds (common random numbers). Throws Interrupted when a
  // simulation does; what had ended by then is in the journal.
  std::vector<Evaluation> evaluate(const std::string& stage,
                                   std::span<const EvaluationPoint> points,
                                   std::span<const std::uint64_t> seeds,
                                   const SimulationProgress& progress = {});

  const Comparison& comparison() const { return *comparison_; }
  std::size_t scenes() const { return scenes_.size(); }
  // Simulations that were really run, not read back.
  int simulated() const { return simulated_; }

 private:
  SimulatedRun measured(std::size_t scene, EngineRun run) const;

  std::vector<Scene> scenes_;
  Journal& journal_;
  std::shared_ptr<const Comparison> comparison_;
  Executor& executor_;
  std::atomic<int> simulated_ = 0;
};

// `count` seeds for a purpose, all different, fixed by the caller's seed.
std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count);

}  // namespace graintruth::calibrate
