// Many simulations at once: every (parameters, seed) pair is looked up in the journal or simulated,
// on all cores, with the same outcome for any number of them.
#pragma once

#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/agreement.h"
#include "calibrate/journal.h"
#include "calibrate/objective.h"

namespace graintruth::calibrate {

// What simulations are compared with.
struct Target {
  Band replicates;
  HalfWidths widths;
};

// All runs at one parameter set, and the mean over those that completed.
struct Evaluation {
  std::string stage;
  ParameterSet parameters;
  double time_step_fraction = 0.0;
  std::vector<SimulatedRun> runs;  // one a seed
  int failed = 0;                  // runs that did not complete
  datasets::Trajectories mean;     // over completed runs
  double objective = 0.0;          // of the mean; that of rest where most runs failed
  double seconds = 0.0;            // processor time of its simulations
};

struct EvaluationPoint {
  ParameterSet parameters;
  double time_step_fraction = 0.0;
};

// Called after each simulation, one at a time: simulations done in this batch, batch size, whether
// it came from the journal.
using SimulationProgress = std::function<void(int done, int total, bool from_journal)>;

class Ensemble {
 public:
  // Any simulation is identified by `problem` and its request. `jobs` threads at most.
  Ensemble(Simulator simulator, Journal& journal, std::string problem, Target target, int jobs);

  // Evaluates all points with the same seeds (common random numbers). Throws Interrupted when a
  // simulation does; what had ended by then is in the journal.
  std::vector<Evaluation> evaluate(const std::string& stage,
                                   std::span<const EvaluationPoint> points,
                                   std::span<const std::uint64_t> seeds,
                                   const SimulationProgress& progress = {});

  const Target& target() const { return target_; }
  const std::string& problem() const { return problem_; }
  // Simulations that were really run, not read back.
  int simulated() const { return simulated_; }

 private:
  SimulatedRun run_once(const std::string& stage,
                        const SimulationRequest& request,
                        bool& from_journal);
  void summarise(Evaluation& evaluation) const;

  Simulator simulator_;
  Journal& journal_;
  std::string problem_;
  Target target_;
  int jobs_;
  std::atomic<int> simulated_ = 0;
};

// `count` seeds for a purpose, all different, fixed by the caller's seed.
std::vector<std::uint64_t> make_seeds(std::uint64_t seed, std::string_view purpose, int count);

// Standard deviation of the ensemble objective that comes from its seeds alone: delete-one
// jackknife over the runs.
double objective_noise(const Target& target, std::span<const SimulatedRun> runs);

// The trajectories of the completed runs.
std::vector<datasets::Trajectories> completed_tracks(std::span<const SimulatedRun> runs);

// Runs `task(i)` for i in [0, count) on `jobs` threads. The first exception is rethrown after all
// threads have stopped.
void parallel_for(int count, int jobs, const std::function<void(int)>& task);

}  // namespace graintruth::calibrate
