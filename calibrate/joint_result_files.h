// What a joint calibration leaves: a folder of its own, and one for every experiment in it.
#pragma once

#include <filesystem>
#include <span>

#include "calibrate/joint_calibration.h"
#include "datasets/run_folder.h"

namespace graintruth::calibrate {

// result.json and the tables of the search; the experiments have theirs by write_calibration and
// write_bin_calibration, in the folders of their names. `wall_time` in s.
void write_joint_calibration(const datasets::RunFolder& folder,
                             const datasets::Experiment& common,
                             std::span<const JointMember> members,
                             const CalibrationOptions& options,
                             const JointCalibrationResult& result,
                             double wall_time);

}  // namespace graintruth::calibrate
