// The main job: parameters that make simulations agree with one experiment, or with several on the
// same grains and walls.
#pragma once

#include "calibrate/knowledge/influence.h"
#include "calibrate/problem.h"
#include "calibrate/result/confirmation.h"
#include "calibrate/search/search.h"

namespace graintruth::calibrate {

// One experiment, with its weight in the sum that is minimised.
struct CalibratedExperiment {
  std::string name;
  const Problem* problem = nullptr;
  double weight = 1.0;
};

// What the parameters found mean to one experiment: its own evaluations and warnings, with the
// parameters and intervals of all.
struct ExperimentResult : SearchResult {
  Confirmed confirmed;
  std::vector<InfluenceRow> influence;
};

struct CalibrationResult : SearchResult {
  double objective = 0.0;  // of fresh simulations: the weighted sum
  int simulated = 0;       // really run, not read back from the journal
  std::vector<ExperimentResult> experiments;
};

// What a calibration does where nothing else is asked. Where every replicate is simulated from a
// start of its own, one simulation of each makes an evaluation.
CalibrationOptions default_options(std::span<const CalibratedExperiment> experiments);

// What a calibration costs at most, in simulations at the largest time step.
double expected_cost(std::span<const CalibratedExperiment> experiments,
                     const CalibrationOptions& options);

// The parts of all problems, by names that tell experiments apart, for the journal.
ProblemParts parts_of(std::span<const CalibratedExperiment> experiments);

// `common` states what is tuned. Deterministic in problems, options and engines; resumes by being
// run again on the same journal. Where an evaluation has fewer seeds than an experiment would have
// alone, because another one simulates every replicate, say, its conditions are simulated several
// times with each of them: a single run is as noisy as a replicate. Throws TooManyFailures.
CalibrationResult calibrate(const datasets::Experiment& common,
                            std::span<const CalibratedExperiment> experiments,
                            Journal& journal,
                            Executor& executor,
                            const EngineOptions& engine_options,
                            const CalibrationOptions& options);

}  // namespace graintruth::calibrate
