// What tells of pictures that were repeated or lost, where three witnesses agree. The clock: no
// time stamp accounts for it. The content: the picture shows nothing new, or clearly more of it
// than its neighbours. The motion: nothing has moved, or everything that moves several steps at
// once.
#pragma once

#include <string>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

struct ClockFaults {
  std::vector<int> repeated;  // frames that show what the one before shows
  std::vector<int> jumps;     // frames before which at least one picture is missing
};

// What the reader of a film knows of each picture, see VideoReader.
struct PictureClock {
  std::vector<double> moments;  // in intervals of the frame rate after the first one
  std::vector<double> changes;  // of each frame of the file: grey levels, mean, from the one before
  int pictures_a_frame = 1;     // two where each frame is woven of two fields
};

// Looks only where several particles move by more than half a pixel (`pixel`, m) a step before and
// after: what lies between them, at constant acceleration, is half the sum of both. How well that
// holds in the rest of the film is the noise that a fault must stand out of.
ClockFaults find_clock_faults(const datasets::Trajectories& tracks,
                              double pixel,
                              const PictureClock& clock);

// Sentences for the summary; frames that `known` lists already are not told again.
std::vector<std::string> describe(const ClockFaults& faults, const std::vector<int>& known);

}  // namespace graintruth::tracking
