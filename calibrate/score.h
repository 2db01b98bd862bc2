// The score that is reported: that of the mean over fresh-seed runs at given parameters, with
// everything that one needs to read it.
#pragma once

#include "calibrate/agreement.h"
#include "calibrate/ensemble.h"
#include "calibrate/problem.h"

namespace graintruth::calibrate {

struct Score {
  Evaluation evaluation;                     // the runs and their mean
  Agreement thesis;                          // 1.96
  Agreement student;                         // Student's t
  double thesis_without_first_frame = 0.0;   // %
  double student_without_first_frame = 0.0;  // %
  double thesis_single_run_median = 0.0;     // %, over the completed runs
  double student_single_run_median = 0.0;    // %
  double rms_position = 0.0;                 // m
};

// What can be said of the score before any model is run.
struct ScoreContext {
  double thesis_ceiling = 0.0;  // %, a perfect model averaged over the same number of runs
  double student_ceiling = 0.0;
  double thesis_leave_one_out = 0.0;  // %, a replicate against the others
  double student_leave_one_out = 0.0;
};

ScoreContext score_context(const Problem& problem, int runs);

// Runs (or reads back) the seeds at these parameters and scores them.
Score score(const Problem& problem,
            Ensemble& ensemble,
            const std::string& stage,
            const EvaluationPoint& point,
            std::span<const std::uint64_t> seeds,
            const SimulationProgress& progress = {});

double median(std::vector<double> values);

}  // namespace graintruth::calibrate
