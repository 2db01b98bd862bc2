// What gives a film its scale: discs, clicked points, a chessboard or a stick, seen in its first
// picture and turned into one camera model.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/view/camera.h"
#include "tracking/view/fiducials.h"

namespace graintruth::tracking {

// What was seen of it.
struct SeenScale {
  std::string name;  // of what was looked for: "fiducials", "points", "corners" or "stick"
  int given = 0, found = 0;
  std::vector<CameraReference> references;  // those that were found; none of a stick
  std::vector<FiducialSighting> sightings;  // discs, which show whether the camera stands still
  double expected_sigma_px = 0.05;          // of a reference, per axis
};
// Throws InputError where a picture of a chessboard cannot be read; `film` names files.
SeenScale look_for_scale(const datasets::Camera& stated,
                         const cv::Mat& first_frame,
                         const datasets::Film& film);

// The camera that sees it so. Throws InputError where too little was seen, or the lens cannot be
// calibrated.
Calibration calibrate(const SeenScale& seen,
                      const datasets::Camera& stated,
                      const cv::Size& size,
                      const datasets::Film& film);

}  // namespace graintruth::tracking
