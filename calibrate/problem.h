// One calibration problem: an experiment and its tracks, measured once, in the form that every
// stage works from.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibrate/journal.h"
#include "calibrate/track_comparison.h"
#include "datasets/experiment.h"

namespace graintruth::calibrate {

// How the particles lie before the event: the mean over replicates, and the spread with which
// replicates were placed.
struct StartPoses {
  std::vector<datasets::Pose> mean;  // one a particle
  datasets::Pose
      standard_deviation;  // pooled over particles: five values a particle would say little
};

struct Problem {
  datasets::Experiment experiment;
  std::shared_ptr<const TrackComparison> comparison;  // of the replicates, at the measurement times
  StartPoses starts;
  ProblemParts parts;  // everything that decides a simulation or its comparison
  std::string hash;    // of all parts
};

// Throws datasets::InputError for an experiment whose tracks cannot be compared with simulations
// particle by particle: a bin (see bin_problem.h), or particles without spheres.
void require_comparable(const datasets::Experiment& experiment);

// `tracks` are the replicates' full tracks, in the order of the experiment file. Throws
// datasets::InputError when the experiment is not comparable or they do not fit it: another number
// of particles, or a recording that does not reach the last measured frame.
Problem make_problem(const datasets::Experiment& experiment,
                     std::span<const datasets::Trajectories> tracks);

// Where the particles rest before the event: per replicate the mean over its still frames (at most
// the last 0.2 s before time 0; the pose at 0 where the film has none), then mean and spread over
// replicates.
StartPoses measure_starts(std::span<const datasets::Trajectories> tracks);

}  // namespace graintruth::calibrate
