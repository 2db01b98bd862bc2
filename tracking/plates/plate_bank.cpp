#include "tracking/plates/plate_bank.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace graintruth::tracking {

namespace {

constexpr int angles = 12;    // 15 degrees apart: half of it turns a rim by a pixel or less
constexpr double ring = 1.2;  // outer size of the ring; gaps between plates are as narrow
constexpr double least_response = 0.1;  // a plate deep in the bed still has gaps about it
constexpr double overlap_limit = 0.8;   // touching scale below which two candidates are one

// +1/n on the plate, and separately +1/m on the ring; body coordinates as in BedFit.
struct Kernels {
  cv::Mat1f plate, ring;
};

Kernels kernels_of(const Eigen::Matrix2d& to_body, int half_width, int half_height) {
  Kernels kernels{cv::Mat1f::zeros(2 * half_height + 1, 2 * half_width + 1),
                  cv::Mat1f::zeros(2 * half_height + 1, 2 * half_width + 1)};
  for (int y = -half_height; y <= half_height; ++y) {
    for (int x = -half_width; x <= half_width; ++x) {
      const double r = (to_body * Eigen::Vector2d(x, y)).norm();
      if (r < 0.95)
        kernels.plate(y + half_height, x + half_width) = 1.0F;
      else if (r > 1.0 && r < ring)
        kernels.ring(y + half_height, x + half_width) = 1.0F;
    }
  }
  kernels.plate /= cv::sum(kernels.plate)[0];
  kernels.ring /= cv::sum(kernels.ring)[0];
  return kernels;
}

}  // namespace

std::vector<PlateCandidate> find_plates(const BedView& view,
                                        const cv::Mat1f& contrast,
                                        double least_gain) {
  const Camera& camera = *view.camera;
  const Eigen::Vector2d middle = camera.unproject(
      {view.region.x + 0.5 * view.region.width, view.region.y + 0.5 * view.region.height});
  const Eigen::Matrix2d jacobian = camera.jacobian(middle.x(), middle.y());
  // 1. The best response over all angles at each pixel
  cv::Mat1f best(contrast.size(), 0.0F), gains(contrast.size(), 0.0F);
  cv::Mat1b best_angle(contrast.size(), std::uint8_t{0});
  cv::Mat1f seen = contrast.clone();
  seen.setTo(0.0F, view.usable == 0);
  for (int k = 0; k < angles; ++k) {
    const double angle = std::numbers::pi * k / angles;
    Eigen::Matrix2d axes;
    axes << std::cos(angle) * view.shape.semi_major, -std::sin(angle) * view.shape.semi_minor,
        std::sin(angle) * view.shape.semi_major, std::cos(angle) * view.shape.semi_minor;
    const Eigen::Matrix2d to_pixel = jacobian * axes;
    const Eigen::Vector2d half = ring * to_pixel.rowwise().norm();
    const Kernels kernels = kernels_of(to_pixel.inverse(),
                                       static_cast<int>(std::ceil(half.x())),
                                       static_cast<int>(std::ceil(half.y())));
    cv::Mat1f plate, around;
    cv::filter2D(seen, plate, CV_32F, kernels.plate, {-1, -1}, 0.0, cv::BORDER_CONSTANT);
    cv::filter2D(seen, around, CV_32F, kernels.ring, {-1, -1}, 0.0, cv::BORDER_CONSTANT);
    for (int row = 0; row < best.rows; ++row) {
      for (int column = 0; column < best.cols; ++column) {
        const float gain = plate(row, column);
        if (gain < least_gain) continue;
        const float response = (gain - around(row, column)) / gain;
        if (response <= best(row, column)) continue;
        best(row, column) = response;
        gains(row, column) = gain;
        best_angle(row, column) = static_cast<std::uint8_t>(k);
      }
    }
  }
  // 2. Local maxima, best first
  cv::Mat1f highest;
  cv::dilate(best, highest, cv::Mat::ones(5, 5, CV_8U));
  std::vector<PlateCandidate> maxima;
  for (int row = 0; row < best.rows; ++row) {
    for (int column = 0; column < best.cols; ++column) {
      const float response = best(row, column);
      if (response < least_response || response < highest(row, column)) continue;
      const Eigen::Vector2d at = camera.unproject({view.region.x + column, view.region.y + row});
      maxima.push_back({{at.x(), at.y(), std::numbers::pi * best_angle(row, column) / angles},
                        response,
                        gains(row, column)});
    }
  }
  std::stable_sort(maxima.begin(), maxima.end(), [](const auto& a, const auto& b) {
    return a.response > b.response;
  });
  // 3. One a place
  std::vector<PlateCandidate> chosen;
  for (const PlateCandidate& candidate : maxima) {
    const bool taken = std::any_of(chosen.begin(), chosen.end(), [&](const auto& other) {
      const double distance =
          std::hypot(other.pose.x - candidate.pose.x, other.pose.z - candidate.pose.z);
      return distance < 2.0 * view.shape.semi_major &&
             touching_scale(other.pose, candidate.pose, view.shape) < overlap_limit;
    });
    if (!taken) chosen.push_back(candidate);
  }
  return chosen;
}

}  // namespace graintruth::tracking
