// How well simulations at given parameters reproduce what ran out of a bin on film.
#pragma once

#include <limits>
#include <vector>

#include "calibrate/bin_fits.h"
#include "calibrate/bin_problem.h"
#include "calibrate/ensemble.h"

namespace graintruth::calibrate {

// A share of runs with its 95 % interval (Jeffreys: equal-tailed beta of k + 1/2, n - k + 1/2).
struct Probability {
  int happened = 0;
  int runs = 0;
  double lower = 0.0, upper = 0.0;
};
Probability probability_of(int happened, int runs);

// One orifice, filmed and simulated at the calibrated parameters, in the terms of ASME V&V 20:
//   E = S - D,   u_val^2 = u_D^2 + u_S^2 + u_input^2 + u_num^2
struct OrificeComparison {
  double orifice = 0.0;  // m
  bool held_out = false;
  // Means over those that did not jam, kg/s; NaN where all did
  double filmed = 0.0;     // over films
  double simulated = 0.0;  // over fresh runs
  // Standard uncertainties, kg/s: scatter of films and of runs, what the parameters' uncertainty
  // does, and the change from half the time step.
  double film_error = 0.0;
  double run_error = 0.0;
  double input_error = 0.0;
  double numerical_error = 0.0;
  Probability filmed_jams, simulated_jams;
  // Share of the film's duration in which the mean simulated discharge curve lies where a further
  // film would with 95 %.
  double curve_inside = 0.0;
  // m, by columns half a particle diameter wide (see BinMeasurement): what stands still while the
  // rest flows, mean over films and over fresh runs. Empty where none flowed steadily.
  std::vector<double> filmed_stagnant, simulated_stagnant;
  double stagnant_overlap = std::numeric_limits<double>::quiet_NaN();  // of the two areas, 0 to 1

  double error() const { return simulated - filmed; }
  double validation_uncertainty() const;
};

struct BinCurvePoint {
  double time = 0.0;                              // s
  double filmed = 0.0, lower = 0.0, upper = 0.0;  // particles; mean, and band of a further film
  double simulated = 0.0;                         // particles; mean
  double simulated_lower = 0.0, simulated_upper = 0.0;  // lowest and highest run
};

struct BinScore {
  Evaluation evaluation;                      // fresh runs of every film
  std::vector<SimulatedRun> calibrated_runs;  // of these, the films that are not held out
  BinComparison::Shares shares;               // of the objective of those
  std::vector<OrificeComparison> orifices;
  std::vector<std::vector<BinCurvePoint>> curves;  // one an orifice
  BinFits filmed, simulated;
  double simulated_modulus = 0.0;  // Pa
  double mean_signed_error = 0.0;  // mean of E/D over orifices that are not held out
  std::vector<Evaluation> others;  // at half the time step and at other parameters; for counting
  std::vector<std::string> warnings;
};

struct BinScoreOptions {
  std::uint64_t seed = 1;
  int runs = 3;  // fresh ones of every film
  // Parameter sets that the films cannot tell from the scored ones: what they predict otherwise is
  // the uncertainty of the input.
  std::vector<ParameterSet> alternatives;
};

// `all` simulates every film. `progress` is told of batches one after the other, with the cost of
// their simulations in units of one at the time step of `point`.
BinScore score_bin(const BinProblem& problem,
                   Ensemble& all,
                   const EvaluationPoint& point,
                   const BinScoreOptions& options,
                   const std::function<SimulationProgress(double cost)>& progress);

// Simulations that score_bin makes.
int simulations_of_score(const BinProblem& problem, int runs, int alternatives);

}  // namespace graintruth::calibrate
