// Dark dots on light tabs, found in a picture without being told where, and named by their known
// layout.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "datasets/experiment/camera.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

// A dot that was found in the picture.
struct FiducialSighting {
  int fiducial = -1;                                // index into the list of fiducials
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // centre of area
  double diameter_px = 0.0;
};

// A dark, round, closed patch.
struct DarkDot {
  Eigen::Vector2d centre;  // px
  double diameter = 0.0;   // px, of the disc of the same area
};

// All patches that could be one of these dots, over all grey levels at which they might separate
// from their ground.
std::vector<DarkDot> find_dark_dots(const cv::Mat& grey,
                                    const std::vector<datasets::Fiducial>& fiducials);

// The assignment of dots to fiducials that explains most of them: two dots fix a similarity
// (upright camera, the scale also told by the dots' size), and what agrees with it fixes a tilted
// view by which the others are found. Sub-pixel centres by
// edges along rays. Empty when nothing fits.
std::vector<FiducialSighting> find_fiducials(const cv::Mat& grey,
                                             const std::vector<datasets::Fiducial>& fiducials,
                                             double pixel_aspect);

// Centre of a dot by the half-height crossing of its edge along rays, to a few hundredths of a
// pixel; false when there is no dot about `sighting`.
bool refine_fiducial(const cv::Mat& grey, FiducialSighting& sighting);

}  // namespace graintruth::tracking
