// One frame prepared for measuring edges: slightly smoothed, in floating point, only where it is
// needed.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>

namespace graintruth::tracking {

class EdgeImage {
 public:
  // `region` of the frame, in its pixels; its brightness is smoothed by a Gaussian of `blur_px`,
  // its colour by more.
  EdgeImage(const cv::Mat& frame, const cv::Rect& region, double blur_px);

  bool contains(const Eigen::Vector2d& pixel, double margin) const;
  // Brightness and two differences of colour (Y, Cr, Cb; 0 is black, and grey) at a pixel of the
  // whole frame, bilinear. The pixel must be contained with a margin of 1.
  Eigen::Vector3f at(const Eigen::Vector2d& pixel) const;
  // True where the sensor was full: highlights have edges of their own.
  bool is_saturated(const Eigen::Vector2d& pixel) const;

 private:
  cv::Rect region_;
  cv::Mat smooth_;     // CV_32FC3, of the region
  cv::Mat saturated_;  // CV_8U, of the region
};

// Standard deviation of the camera's noise in one channel, grey levels, from how the frame differs
// from its own neighbourhood where it is smooth (Immerkaer 1996, with a median in place of the mean
// so that edges do not count).
double camera_noise(const cv::Mat& frame);

}  // namespace graintruth::tracking
