// A calibration on films of a bin: each film measured, with the bed that it began with.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibrate/bin_comparison.h"
#include "calibrate/problem.h"
#include "datasets/experiment.h"

namespace graintruth::calibrate {

// What one film gives to its simulation.
struct BinStart {
  datasets::Experiment experiment;  // as this replicate was filmed
  BulkRig rig;
  std::vector<datasets::Pose> bed;                   // one a particle, at rest
  datasets::Pose standard_deviation{0.0, 0.0, 0.0};  // of one tracked pose
  double duration = 0.0;                             // s, from the opening to the end of the film
  double frame_interval = 0.0;                       // s
  double profile_height = 0.0;  // m; where the film's velocity profile is taken
  double impact_speed = 0.0;    // m/s; of a fall by the widest orifice of the experiment
  bool held_out = false;
  std::string hash;  // of everything that decides this simulation besides its request
};

struct BinProblem {
  datasets::Experiment experiment;
  std::vector<BinStart> starts;                     // one a film
  std::shared_ptr<const BinComparison> all;         // with every film, in the order of `starts`
  std::shared_ptr<const BinComparison> calibrated;  // with those that are not held out
  std::vector<std::size_t> calibrated_films;        // indices into `starts`
  ProblemParts parts;                               // one a film
};

// Throws datasets::InputError for a bin of particles that are no plates: nothing else is measured
// of it.
void require_plates(const datasets::Experiment& experiment);

// `tracks` are the replicates' full tracks, in the order of the experiment file. Held out is what
// the file says; where it says nothing, orifices narrower than six particle diameters, whose flow
// arches (thesis 4.3.3), as long as two wider ones remain. Throws datasets::InputError for an
// experiment without plates, for another number of particles than stated, for a film that shows no
// bed at rest, where films of one orifice are held out and others are not, and where no
// calibrated orifice has two films.
BinProblem make_bin_problem(const datasets::Experiment& experiment,
                            std::span<const datasets::Trajectories> tracks);

}  // namespace graintruth::calibrate
