#include "tracking/view/mask.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

namespace graintruth::tracking {

cv::Mat1b masked_pixels(const std::vector<datasets::MaskPolygon>& polygons, const cv::Size& size) {
  cv::Mat1b covered(size, std::uint8_t{0});
  for (const datasets::MaskPolygon& polygon : polygons) {
    std::vector<cv::Point> corners;
    for (const auto& [column, row] : polygon.corners)
      corners.emplace_back(static_cast<int>(std::lround(column)),
                           static_cast<int>(std::lround(row)));
    cv::fillPoly(covered, std::vector{corners}, cv::Scalar(255));
  }
  return covered;
}

void Mask::cover(cv::Mat& frame) {
  if (!polygons_) return;
  if (patch_.empty()) {
    covered_ = masked_pixels(*polygons_, frame.size());
    constexpr double reach = 3.0;  // px, that decide a pixel
    cv::inpaint(frame, covered_, patch_, reach, cv::INPAINT_TELEA);
  }
  // What the caller holds may be shared with the reader
  frame = frame.clone();
  patch_.copyTo(frame, covered_);
}

}  // namespace graintruth::tracking
