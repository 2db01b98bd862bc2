// How grains lie before the event, as tracks show it.
#pragma once

#include <span>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::calibrate {

// The mean over replicates, and the spread with which replicates were placed.
struct StartPoses {
  std::vector<datasets::Pose> mean;  // one a particle
  datasets::Pose
      standard_deviation;  // pooled over particles: five values a particle would say little
};

// Where the particles rest before the event: per replicate the mean over its still frames (at most
// the last 0.2 s before time 0; the pose at 0 where the film has none), then mean and spread over
// replicates.
StartPoses measure_starts(std::span<const datasets::Trajectories* const> tracks);

// The same of one recording; a particle that is not seen then, where it is seen first. NaN where it
// is never seen.
std::vector<datasets::Pose> start_places(const datasets::Trajectories& track);

// Median over particles and frames of what a tracker says of its own error; where it says nothing,
// far below any camera's, and enough for seeds to tell runs apart.
datasets::Pose typical_error(const datasets::Trajectories& track);

}  // namespace graintruth::calibrate
