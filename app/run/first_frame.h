// The first frame of each film: enough to see, before any long work, what a film can and cannot do.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::app {

// Throws datasets::InputError where no frame of the film can be read.
void require_first_frame(const datasets::TrackingSpec& spec, const datasets::Film& film);

struct FirstFrame {
  int width = 0, height = 0;         // px
  int declared_frames = 0;           // by the film's header; 0 when it does not say
  double declared_frame_rate = 0.0;  // Hz
  std::string scale_from;            // "fiducials", "points", "corners" or "stick"
  int given = 0, found = 0;          // of these
  std::string complaint;             // why there is no camera
  std::optional<double> residual;    // m, rms of them about the camera model
  std::optional<double> scale;       // px/m, in their middle
};

// Looks for what gives scale and calibrates the camera where enough is found; then writes
// `picture`, the frame with what the experiment file says drawn over it: the rig, the particles'
// starting places, fiducials found and missed. Without a calibration it shows every dark
// dot that could be a fiducial. Throws datasets::InputError where no frame can be read.
FirstFrame look_at_first_frame(const datasets::TrackingSpec& spec,
                               const datasets::Film& film,
                               const std::filesystem::path& picture);

}  // namespace graintruth::app
