// What the answer owes to a single replicate or particle: the parameters that would have been best
// without it, of those that were simulated. Nothing is simulated anew.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/channel_comparison.h"

namespace graintruth::calibrate {

struct InfluenceRow {
  std::string left_out;    // "replicate 3" or "particle 7", numbered from 1
  ParameterSet best;       // of the evaluations, without it
  double objective = 0.0;  // there, without it
};

// Of a comparison of one experiment. First all replicates, then all particles where tracks are
// compared; none of a kind of which fewer than three are there. The order of evaluations breaks
// ties.
std::vector<InfluenceRow> influence_of_each(const ChannelComparison& comparison,
                                            std::span<const Evaluation> evaluations);

}  // namespace graintruth::calibrate
