// A picture as it would look square to the plane of the scale: its columns are columns of the
// plane, whatever the camera's tilt and lens.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/view/camera.h"

namespace graintruth::tracking {

// A grid of points of the plane, m. Rows go downwards.
class PlaneGrid {
 public:
  PlaneGrid() = default;
  // Square cells of this size; the first has its middle at (left_x, top_z).
  PlaneGrid(double left_x, double top_z, double cell, cv::Size size)
      : left_x_(left_x), top_z_(top_z), cell_(cell), size_(size) {}

  double x(double column) const { return left_x_ + column * cell_; }
  double z(double row) const { return top_z_ - row * cell_; }
  double column(double x) const { return (x - left_x_) / cell_; }
  double row(double z) const { return (top_z_ - z) / cell_; }
  double cell() const { return cell_; }  // m
  const cv::Size& size() const { return size_; }

  // Cells whose middle lies in a polygon (m), 255; others 0.
  cv::Mat1b inside(const std::vector<Eigen::Vector2d>& polygon) const;

 private:
  double left_x_ = 0.0, top_z_ = 0.0, cell_ = 1.0;
  cv::Size size_;
};

class PlanePicture {
 public:
  PlanePicture() = default;
  // `region`: the part of the picture that is looked at, px. `masked`: pixels that nobody is to
  // look at, 255; empty: none.
  PlanePicture(const PlaneGrid& grid,
               const Camera& camera,
               const cv::Rect& region,
               const cv::Mat1b& masked = {});

  const PlaneGrid& grid() const { return grid_; }
  // Cells that the picture shows, 255; others 0.
  const cv::Mat1b& seen() const { return seen_; }
  cv::Mat of(const cv::Mat& frame) const;

 private:
  PlaneGrid grid_;
  cv::Mat map_x_, map_y_;
  cv::Mat1b seen_;
};

}  // namespace graintruth::tracking
