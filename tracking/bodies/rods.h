// Straight rods of one width and any apparent length, crossing each other, on an even ground:
// ribbons of one colour. A rod that passes behind others is followed to the far side.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

namespace graintruth::tracking {

struct RodOptions {
  double width_px = 7.0;
  double longest_px = 120.0;
  cv::Rect region;  // px, where rods may be; empty: the whole picture
};

struct Rod {
  Eigen::Vector2d from, to;  // px, the middles of its ends; integers at pixel centres
  Eigen::Vector3f colour;    // CIE L*a*b*
  double coverage = 0.0;     // 0..1, the share of its area in which its colour is seen
  // px, standard deviations: of its ends along the rod, and of its middle across it
  double from_sigma_px = 0.0, to_sigma_px = 0.0, across_sigma_px = 0.0;

  Eigen::Vector2d centre() const { return 0.5 * (from + to); }
  double length() const { return (to - from).norm(); }
  // rad in [0, pi), counter-clockwise from +x as one sees the picture (rows grow downwards)
  double angle() const;
};

// The rods of a picture (8-bit BGR), longest first; each pixel belongs to one rod at most. A rod
// seen end-on is shorter than wide and not found. `expected` rods, such as those of the picture
// before, are looked for first, where they should be.
std::vector<Rod> locate_rods(const cv::Mat& frame,
                             const RodOptions& options,
                             const std::vector<Rod>& expected = {});

}  // namespace graintruth::tracking
