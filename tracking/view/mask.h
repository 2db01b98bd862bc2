// Parts of the picture that nobody is to look at.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "datasets/experiment/camera.h"

namespace graintruth::tracking {

// Pixels of a picture of this size inside any of the polygons, 255; others 0.
cv::Mat1b masked_pixels(const std::vector<datasets::MaskPolygon>& polygons, const cv::Size& size);

// Covers them in every picture of a film with what surrounds them in the first one: they hold no
// edge and never move.
class Mask {
 public:
  explicit Mask(const datasets::Camera& stated) : polygons_(stated.masks) {}

  void cover(cv::Mat& frame);

 private:
  std::optional<std::vector<datasets::MaskPolygon>> polygons_;
  cv::Mat1b covered_;
  cv::Mat patch_;  // of the size of a picture
};

}  // namespace graintruth::tracking
