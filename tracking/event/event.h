// The start of motion, found on the film: "still, then at a constant speed", to a small part of a
// frame.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

// A height over time; NaN where it could not be measured.
struct HeightRecord {
  std::vector<double> time;    // s from the first frame
  std::vector<double> height;  // m
};

// Follows the edge of a moving face through the film: the gradient along z averaged over the
// width of the face, whose sign stays the same, so that curved or passing things average out.
class FaceWatcher {
 public:
  FaceWatcher(const datasets::MovingFace& face, double rate) : face_(face), frame_rate_(rate) {}

  // Measures the face in the next frame, taken so many intervals of the frame rate after the first;
  // `grey` is 8 bit. Returns the height of the edge, m, or NaN.
  double measure(const cv::Mat& grey, const Camera& camera, double moment);

  const HeightRecord& record() const { return record_; }
  double last_height() const { return last_height_; }

 private:
  datasets::MovingFace face_;
  double frame_rate_;
  double sign_ = 0.0;      // +1: brighter below the edge
  double strength_ = 0.0;  // grey levels a pixel, in the first frame
  double last_height_ = 0.0;
  double last_seen_ = -1.0;  // moment
  HeightRecord record_;
};

struct Event {
  double time = 0.0;         // s from the first frame
  double uncertainty = 0.0;  // s, one standard deviation
  double speed = 0.0;    // m/s, of what was followed, negative downwards; 0 where it was not fitted
  double scatter = 0.0;  // m, of the record about the fit
  std::string how;       // "piston face", ...
};

// Least squares of  z = z0 for t < t0,  z0 + v (t - t0) after it, over the frames up to one second
// after t0, with `expected_speed` held to 2 % (parallax of the face's front edge). Empty when the
// record does not look like that.
std::optional<Event> fit_onset(const HeightRecord& record, double expected_speed);

}  // namespace graintruth::tracking
