// A frame as one channel in which the ground is zero and plates are bright: the colour is projected
// on the direction that tells plates from the ground best, both learned from the film. Linear, so
// that a pixel half covered has half the contrast.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>

namespace graintruth::tracking {

struct Contrast {
  Eigen::Vector3f ground = Eigen::Vector3f::Zero();  // blue, green, red of the bare ground
  Eigen::Vector3f direction = Eigen::Vector3f::UnitY();
  float gain = 1.0F;  // usual contrast of a plate, grey levels
};

// Learned from the pixels of `mask` that lost their plate between the two frames: `full` shows the
// bed, `empty` the same place after it has left. `changed` is the share of the mask that changed.
struct LearnedContrast {
  Contrast contrast;
  double changed = 0.0;
};
LearnedContrast learn_contrast(const cv::Mat& full, const cv::Mat& empty, const cv::Mat& mask);

// The contrast of `region` of a frame.
cv::Mat1f contrast_of(const cv::Mat& frame, const cv::Rect& region, const Contrast& contrast);

}  // namespace graintruth::tracking
