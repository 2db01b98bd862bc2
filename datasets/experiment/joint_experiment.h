// Experiments on the same grains and walls, whose parameters are sought together: balls followed
// one by one in one rig, say, and the flow out of a bin in another.
#pragma once

#include <vector>

#include "datasets/experiment/experiment.h"

namespace graintruth::datasets {

struct JointPart {
  Experiment experiment;  // with the bounds, priors and rules of the joint file in place of its own
  double weight = 1.0;    // of its objective in the sum that is minimised
};

struct JointExperiment {
  // Name, title and note of the joint file, what it tunes, and the bench values of all parts;
  // particle and rig are those of the first part.
  Experiment common;
  std::vector<JointPart> parts;  // two or more, with different names
};

// Whether a file lists experiments instead of being one. Throws InputError where it is no TOML.
bool is_joint(const std::filesystem::path& file);

// Reads and checks the file and all that it lists. Throws InputError as load_experiment does, and
// where two parts have one name or other bench values: then their grains or walls are not the same.
JointExperiment load_joint_experiment(const std::filesystem::path& file);

}  // namespace graintruth::datasets
