// The first frame of each film, and whether the others can be read: enough to see, before any long
// work, what a film can and cannot do.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::app {

// Throws datasets::InputError where no frame of the film can be read, or only one where several are
// needed.
void require_first_frame(const datasets::TrackingSpec& spec, const datasets::Film& film);

struct FirstFrame {
  int width = 0, height = 0;          // px
  int frames = 0;                     // of the whole film
  double length = 0.0;                // s, of the whole film
  std::vector<std::string> warnings;  // what the tracker will say of clock and frames
  std::string scale_from;             // "fiducials", "points", "corners" or "stick"
  int given = 0, found = 0;           // of these
  std::string complaint;              // why there is no camera
  std::optional<double> residual;     // m, rms of them about the camera model
  std::optional<double> scale;        // px/m, in their middle
};

// Looks for what gives scale and calibrates the camera where enough is found; then writes
// `picture`, the frame with what the experiment file says drawn over it: the rig, the particles'
// starting places, fiducials found and missed. Without a calibration it shows every dark
// dot that could be a fiducial. Reads the film to its end. Throws datasets::InputError where the
// tracker would refuse the film.
FirstFrame look_at_first_frame(const datasets::TrackingSpec& spec,
                               const datasets::Film& film,
                               const std::filesystem::path& picture);

}  // namespace graintruth::app
