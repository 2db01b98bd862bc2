// One frame prepared for measuring edges: slightly smoothed, in floating point, only where it is
// needed.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace graintruth::tracking {

class EdgeImage {
 public:
  // `region` of the frame, in its pixels; its brightness is smoothed by a Gaussian of `blur_px`,
  // its colour by more.
  EdgeImage(const cv::Mat& frame, const cv::Rect& region, double blur_px);
  // The same from the part of the frame alone, whose first pixel lies at `corner` of the frame.
  EdgeImage(const cv::Mat& part, const cv::Point& corner, double blur_px);

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

inline Eigen::Vector3f EdgeImage::at(const Eigen::Vector2d& pixel) const {
  const double x = pixel.x() - region_.x, y = pixel.y() - region_.y;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  using Colour = Eigen::Map<const Eigen::Vector3f>;
  const float* top = smooth_.ptr<float>(y0) + 3 * x0;
  const float* bottom = smooth_.ptr<float>(y0 + 1) + 3 * x0;
  return (1.0F - fy) * ((1.0F - fx) * Colour(top) + fx * Colour(top + 3)) +
         fy * ((1.0F - fx) * Colour(bottom) + fx * Colour(bottom + 3));
}

inline bool EdgeImage::is_saturated(const Eigen::Vector2d& pixel) const {
  const int x = static_cast<int>(std::lround(pixel.x())) - region_.x;
  const int y = static_cast<int>(std::lround(pixel.y())) - region_.y;
  return saturated_.at<std::uint8_t>(y, x) != 0;
}

// Standard deviation of the camera's noise in one channel, grey levels, from how the frame differs
// from its own neighbourhood where it is smooth (Immerkaer 1996, with a median in place of the mean
// so that edges do not count).
double camera_noise(const cv::Mat& frame);

// Smooths a frame of that much noise (grey levels) until no more than about three grey levels are
// left: by a Gaussian of up to two pixels. Quieter frames stay as they are.
void quieten(cv::Mat& frame, double noise);

// What edges in an EdgeImage of this frame have to stand out from, grey levels: what its smoothing
// leaves of the camera's `noise`, or what compression does, which goes with the range of brightness
// that the frame uses and is 1 from half of all levels on.
double edge_noise(const cv::Mat& frame, double noise);

}  // namespace graintruth::tracking
