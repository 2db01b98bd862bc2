// Many simulations at once: every (parameters, seed) pair is looked up in the journal or simulated,
// on all cores, with the same outcome for any number of them.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibrate/comparison.h"
#include "calibrate/journal.h"

namespace graintruth::calibrate {

struct EvaluationPoint {
  ParameterSet parameters;
  double time_step_fraction = 0.0;
};

// Called after each simulation, one at a time: simulations done in this batch, batch size, whether
// it came from the journal.
using SimulationProgress = std::function<void(int done, int total, bool from_journal)>;

// One simulated situation. Any simulation is identified by `problem`, the hash of everything that
// matters besides the request, and its request.
struct Scene {
  std::string problem;
  Simulator simulator;
};

class Ensemble {
 public:
  // An evaluation simulates every scene with every seed, on `jobs` threads at most. A run that
  // becomes unstable is tried once more at half the time step.
  Ensemble(std::vector<Scene> scenes,
           Journal& journal,
           std::shared_ptr<const Comparison> comparison,
           int jobs);

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
  static SimulatedRun simulate(const Simulator& simulator, const SimulationRequest& request);
  SimulatedRun run_once(const std::string& stage,
                        std::size_t scene,
                        const SimulationRequest& request,
                        bool& from_journal);
  void summarise(Evaluation& evaluation) const;

  std::vector<Scene> scenes_;
  Journal& journal_;
  std::shared_ptr<const Comparison> comparison_;
  int jobs_;
  std::atomic<int> simulated_ = 0;
};

// `count` seeds for a purpose, all different, fixed by the caller's seed.
std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count);

// Runs `task(i)` for i in [0, count) on `jobs` threads. The first exception is rethrown after all
// threads have stopped.
void parallel_for(int count, int jobs, const std::function<void(int)>& task);

}  // namespace graintruth::calibrate
