// A calibration on films of a bin: each film measured, with the bed that it began with.
#pragma once

#include <memory>
#include <optional>
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
  // One a particle, at rest; empty where the film does not tell: then every run prepares its own
  std::vector<datasets::Pose> bed;
  int prepared_bed = 0;  // numbers films without a bed: each gets beds of its own
  datasets::Pose standard_deviation{0.0, 0.0, 0.0};  // of one tracked pose
  double duration = 0.0;                             // s, from the opening to the end of the film
  double frame_interval = 0.0;                       // s
  // m; where the film's velocity profile is taken; half way up the bed where it has none
  std::optional<double> profile_height;
  double impact_speed = 0.0;  // m/s; of a fall by the widest orifice of the experiment
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
  std::vector<std::string> warnings;                // what some films do not tell
};

// What one replicate of a bin gave: tracks, or else a discharge curve.
struct BinRecord {
  datasets::Trajectories tracks;
  std::optional<datasets::DischargeCurve> curve;
};
BinMeasurement measure_bin(const BinRecord& record,
                           const datasets::Experiment& experiment,
                           const datasets::Replicate& replicate);

// Throws datasets::InputError for a bin of particles that are no plates: nothing else is measured
// of it.
void require_plates(const datasets::Experiment& experiment);

// `records` are the replicates' full tracks or curves, in the order of the experiment file. Where
// one tells no bed (a curve, tracks without angles) its simulations start from prepared beds. Held
// out is what
// the file says; where it says nothing, orifices narrower than six particle diameters, whose flow
// arches (thesis 4.3.3), as long as two wider ones remain. Throws datasets::InputError for an
// experiment without plates, for another number of particles than stated, for a film that shows no
// bed at rest, where films of one orifice are held out and others are not, and where no
// calibrated orifice has two films.
BinProblem make_bin_problem(const datasets::Experiment& experiment,
                            std::span<const BinRecord> records);

}  // namespace graintruth::calibrate
