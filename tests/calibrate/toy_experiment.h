// An experiment whose every result is known: particles on straight, smooth tracks that depend on
// the parameters in closed form, with noise of known size. For tests of statistics and search, not
// of physics.
#pragma once

#include "calibrate/problem.h"

namespace graintruth::calibrate::toy {

struct Truth {
  ParameterSet parameters{0.2, 0.3, 0.7};
  double noise = 0.002;  // m (and rad) of one run or replicate
};

inline constexpr int particles = 6;
inline constexpr int frames = 12;

// One run at these parameters; restitution has no effect.
datasets::Trajectories run(const ParameterSet& parameters, double noise, std::uint64_t seed);
Simulator simulator(double noise);
// The toy's replicates at the truth, as a problem with bounds 0-0.6, 0-0.7 and 0.3-0.95.
Problem problem(const Truth& truth, int replicates, std::uint64_t seed);

}  // namespace graintruth::calibrate::toy
