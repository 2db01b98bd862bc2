// What is derived from beds that run out through several orifices: mean rates with their
// uncertainty, Beverloo's C and k, the kinematic B. The same for films and for simulations.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/flow/bulk_measure.h"
#include "calibrate/flow/kinematic.h"
#include "calibrate/search/least_squares.h"

namespace graintruth::calibrate {

// One run, filmed, weighed or simulated, as bulk measures see it.
struct BulkRun {
  std::string name;
  BulkRig rig;
  BulkMeasurement measured;
};

// All runs through one orifice that had a steady stretch.
struct OrificeFlow {
  double orifice = 0.0;         // m
  int runs = 0;                 // with a steady stretch
  double rate = 0.0;            // kg/s, mean
  double standard_error = 0.0;  // kg/s, of the mean, from the scatter pooled over orifices
  double half_width = 0.0;      // kg/s, of the 95 % interval; NaN without repeats
  double density = 0.0;         // kg/m2, of the flowing bed; NaN where no run has tracks
  // From the velocity profiles of all runs, with the finite orifice
  std::optional<KinematicFit> kinematic;
  double height = 0.0;          // m, of the profiles, mean
  double flux_over_rate = 0.0;  // -; v rho W over the rate, should be 1
};

struct FlowFits {
  std::vector<OrificeFlow> orifices;  // rising in width
  double particle_diameter = 0.0;     // m
  double relative_scatter = 0.0;      // standard deviation of one run's rate, pooled
  int freedom = 0;                    // of that
  std::optional<LeastSquaresFit>
      beverloo;  // joint (C, k), slot law; needs three orifices with a density
};
FlowFits fit_flow(std::span<const BulkRun> runs, double gravity);

}  // namespace graintruth::calibrate
