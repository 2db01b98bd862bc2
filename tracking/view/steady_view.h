// A camera, or a rig, that moves a little while it films: pictures put back to where the first one
// saw the fiducials.
#pragma once

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "tracking/view/fiducials.h"

namespace graintruth::tracking {

class SteadyView {
 public:
  // `first`: where the first picture shows the fiducials.
  explicit SteadyView(std::vector<FiducialSighting> first);

  // Moves, turns and scales picture `number` of the film so that its fiducials lie where the first
  // picture shows them; leaves it as it is where they do within what can be measured, or where
  // fewer than three can be seen. Pictures come in order: dots are looked for where they were last.
  void hold(cv::Mat& frame, int number);

  // By how much pictures had to be moved, px; 0 for a camera that stands still.
  double largest_shift_px() const { return largest_shift_px_; }
  int frame_of_largest_shift() const { return frame_of_largest_shift_; }
  int unchecked_frames() const { return unchecked_frames_; }  // too few fiducials were seen

 private:
  // Where the first picture shows a fiducial, and where this one does.
  using Pairs = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;
  Pairs pairs_near(const cv::Mat& grey, const Eigen::Vector2d& jump) const;
  Pairs pairs_about(const cv::Mat& grey) const;

  std::vector<FiducialSighting> first_, last_;
  double largest_shift_px_ = 0.0;
  int frame_of_largest_shift_ = 0;
  int unchecked_frames_ = 0;
};

}  // namespace graintruth::tracking
