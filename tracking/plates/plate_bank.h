// Where plates may be when nothing is known yet: a bank of filters, one an angle, each the mean
// over the plate minus the mean over a ring about it.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/plates/bed_fit.h"

namespace graintruth::tracking {

struct PlateCandidate {
  datasets::Pose pose;
  double response = 0.0;  // plate minus ring, over the plate's own contrast; at most about 1
  double gain = 0.0;      // mean contrast of the plate, grey levels
};

// Local maxima over places and angles, best first, that overlap no better one by much. Plates
// fainter than `least_gain` are left out.
std::vector<PlateCandidate> find_plates(const BedView& view,
                                        const cv::Mat1f& contrast,
                                        double least_gain);

}  // namespace graintruth::tracking
