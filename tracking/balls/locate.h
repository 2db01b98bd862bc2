// Where balls of a known radius may be: every edge pixel votes for the two points one radius away
// along its gradient (Ballard 1981, both polarities), in the particle plane, so that lens and pixel
// aspect do not matter.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/view/camera.h"

namespace graintruth::tracking {

// A rectangle of the particle plane, m.
struct PlaneRegion {
  double left = 0.0, right = 0.0, bottom = 0.0, top = 0.0;
};

struct BallCandidate {
  double x = 0.0, z = 0.0;  // m
  double votes = 0.0;       // share of a full outline that voted, about 0..1
};

// The strongest candidates, best first, at most `most`. `noise` is the camera's, in grey levels.
std::vector<BallCandidate> locate_balls(const cv::Mat& frame,
                                        const Camera& camera,
                                        const PlaneRegion& region,
                                        double radius,
                                        double noise,
                                        int most);

}  // namespace graintruth::tracking
