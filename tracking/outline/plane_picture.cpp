#include "tracking/outline/plane_picture.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace graintruth::tracking {

cv::Mat1b PlaneGrid::inside(const std::vector<Eigen::Vector2d>& polygon) const {
  cv::Mat1b mask(size_, std::uint8_t{0});
  if (polygon.size() < 3) return mask;
  constexpr int shift = 8;
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& corner : polygon) {
    corners.emplace_back(static_cast<int>(std::lround(column(corner.x()) * (1 << shift))),
                         static_cast<int>(std::lround(row(corner.y()) * (1 << shift))));
  }
  cv::fillPoly(
      mask, std::vector<std::vector<cv::Point>>{corners}, cv::Scalar(255), cv::LINE_8, shift);
  return mask;
}

PlanePicture::PlanePicture(const PlaneGrid& grid,
                           const Camera& camera,
                           const cv::Rect& region,
                           const cv::Mat1b& masked)
    : grid_(grid),
      map_x_(grid.size(), CV_32F),
      map_y_(grid.size(), CV_32F),
      seen_(grid.size(), std::uint8_t{0}) {
  for (int row = 0; row < grid.size().height; ++row) {
    for (int column = 0; column < grid.size().width; ++column) {
      const Eigen::Vector2d pixel = camera.project(grid.x(column), grid.z(row));
      map_x_.at<float>(row, column) = static_cast<float>(pixel.x());
      map_y_.at<float>(row, column) = static_cast<float>(pixel.y());
      if (pixel.x() >= region.x && pixel.y() >= region.y && pixel.x() <= region.br().x - 1 &&
          pixel.y() <= region.br().y - 1)
        seen_(row, column) = 255;
    }
  }
  // A cell takes from up to four pixels; one that is masked spoils it
  if (!masked.empty()) seen_.setTo(0, of(masked) > 0);
}

cv::Mat PlanePicture::of(const cv::Mat& frame) const {
  cv::Mat result;
  cv::remap(frame, result, map_x_, map_y_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace graintruth::tracking
