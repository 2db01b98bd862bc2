// What the motion itself tells of a film's clock: in a picture that repeats the one before nothing
// has moved, and after pictures that were lost everything has moved several steps at once.
#pragma once

#include <string>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

struct ClockFaults {
  std::vector<int> repeated;  // frames that show what the one before shows
  std::vector<int> jumps;     // frames before which at least one picture is missing
};

// Looks only where several particles move by more than half a pixel (`pixel`, m) a step before and
// after: what lies between them, at constant acceleration, is half the sum of both.
ClockFaults find_clock_faults(const datasets::Trajectories& tracks, double pixel);

// Sentences for the summary; frames that `known` lists already are not told again.
std::vector<std::string> describe(const ClockFaults& faults, const std::vector<int>& known);

}  // namespace graintruth::tracking
