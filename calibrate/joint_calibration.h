// The main job for several experiments on the same grains and walls: one set of parameters for all
// of them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/bin_calibration.h"
#include "calibrate/calibration.h"

namespace graintruth::calibrate {

// One of the experiments, with the scenes that simulate it.
struct JointMember {
  std::string name;
  double weight = 1.0;
  // Exactly one of these is there
  std::optional<Problem> tracks;
  std::optional<BinProblem> bin;
  std::vector<Scene> searched;              // that the search compares
  std::vector<Scene> all;                   // that the result is told of: held-out films as well
  double largest_time_step_fraction = 0.3;  // that its contacts allow
};

// What the parameters found mean to one of the experiments: its own evaluations, score and
// warnings, with the parameters and intervals of all.
struct JointMemberResult {
  double objective = 0.0;  // of fresh simulations, unweighted
  std::optional<CalibrationResult> tracks;
  std::optional<BinCalibrationResult> bin;
};

struct JointCalibrationResult : SearchResult {
  double objective = 0.0;  // of fresh simulations: the weighted sum
  int simulated = 0;       // really run, not read back from the journal
  std::vector<JointMemberResult> members;
};

// What a joint calibration does where nothing else is asked: as a calibration on a bin if there is
// one among them, which costs more than all tracks.
CalibrationOptions joint_options(std::span<const JointMember> members);

// The parts of all problems, by names that tell their experiments apart, for the journal.
ProblemParts parts_of(std::span<const JointMember> members);

// `common` states what is tuned. Where an evaluation has few seeds, because bins simulate every
// film, particles that are followed are simulated several times with each of them: a single run is
// as noisy as a replicate. Throws TooManyFailures.
JointCalibrationResult calibrate_jointly(const datasets::Experiment& common,
                                         std::span<const JointMember> members,
                                         Journal& journal,
                                         const CalibrationOptions& options);

}  // namespace graintruth::calibrate
