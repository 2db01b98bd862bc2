// The main job where particles run out of a bin: parameters that make simulated flow agree with
// filmed flow at some orifices, and what they predict at the others.
#pragma once

#include "calibrate/bin_score.h"
#include "calibrate/search.h"

namespace graintruth::calibrate {

struct BinCalibrationResult : SearchResult {
  BinScore score;
};

// Simulations that a confirmation makes.
int simulations_of_bin_confirmation(const BinProblem& problem, const CalibrationOptions& options);
// How well the parameters that `search` has chosen predict every film, as a further stage of it.
BinScore confirm_bin(const BinProblem& problem,
                     Ensemble& all,
                     const CalibrationOptions& options,
                     Search& search);
// All of it together; the evaluations in `found` are of this problem.
BinCalibrationResult conclude_bin(const BinProblem& problem, SearchResult found, BinScore score);

// `searched` simulates the films that are calibrated on, `all` every film; both on one journal.
// Throws TooManyFailures.
BinCalibrationResult calibrate_bin(const BinProblem& problem,
                                   Ensemble& searched,
                                   Ensemble& all,
                                   const CalibrationOptions& options);

// What a calibration on films of a bin does where nothing else is asked: one simulation a film
// makes an evaluation.
CalibrationOptions bin_options();

}  // namespace graintruth::calibrate
