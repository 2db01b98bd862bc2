#include "tracking/balls/locate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace graintruth::tracking {

std::vector<BallCandidate> locate_balls(const cv::Mat& frame,
                                        const Camera& camera,
                                        const PlaneRegion& region,
                                        double radius,
                                        double noise,
                                        int most) {
  const double middle_x = 0.5 * (region.left + region.right),
               middle_z = 0.5 * (region.bottom + region.top);
  const double cell = 1.0 / camera.scale(middle_x, middle_z);  // m: about a pixel
  const int columns = static_cast<int>((region.right - region.left) / cell) + 1;
  const int rows = static_cast<int>((region.top - region.bottom) / cell) + 1;
  cv::Mat votes = cv::Mat::zeros(rows, columns, CV_32F);

  cv::Mat smooth, gradient_x, gradient_y;
  cv::GaussianBlur(frame, smooth, cv::Size(5, 5), 1.0);
  cv::Sobel(smooth, gradient_x, CV_16S, 1, 0);
  cv::Sobel(smooth, gradient_y, CV_16S, 0, 1);
  // Sobel after this blur passes about 1.9 times the noise of a pixel; five times that is no
  // accident.
  const double threshold = std::max(5.0 * 1.9 * noise, 12.0);
  constexpr int highlight = 250;

  // 1. Votes
  for (int row = 2; row + 2 < frame.rows; ++row) {
    for (int column = 2; column + 2 < frame.cols; ++column) {
      const cv::Vec3s& horizontal = gradient_x.at<cv::Vec3s>(row, column);
      const cv::Vec3s& vertical = gradient_y.at<cv::Vec3s>(row, column);
      int channel = 0;
      double strongest = 0.0;
      for (int c = 0; c < 3; ++c) {
        const double square = static_cast<double>(horizontal[c]) * horizontal[c] +
                              static_cast<double>(vertical[c]) * vertical[c];
        if (square > strongest) {
          strongest = square;
          channel = c;
        }
      }
      if (strongest < threshold * threshold) continue;
      const cv::Vec3b& colour = smooth.at<cv::Vec3b>(row, column);
      if (std::min({colour[0], colour[1], colour[2]}) >= highlight) continue;
      // An edge is a level line; in the plane its normal is J^T times its normal in the picture.
      const Eigen::Vector2d point = camera.unproject(Eigen::Vector2d(column, row));
      if (point.x() < region.left - radius || point.x() > region.right + radius ||
          point.y() < region.bottom - radius || point.y() > region.top + radius)
        continue;
      const Eigen::Vector2d normal = (camera.jacobian(point.x(), point.y()).transpose() *
                                      Eigen::Vector2d(horizontal[channel], vertical[channel]))
                                         .normalized();
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector2d centre = point + sign * radius * normal;
        const int i = static_cast<int>(std::lround((centre.x() - region.left) / cell));
        const int j = static_cast<int>(std::lround((region.top - centre.y()) / cell));
        if (i >= 0 && j >= 0 && i < columns && j < rows) votes.at<float>(j, i) += 1.0F;
      }
    }
  }

  // 2. Sum over a disc: votes scatter by the edge's direction error and by a radius wrong by some
  // per cent
  const double spread = std::max(1.5, 0.06 * radius / cell);
  cv::GaussianBlur(votes, votes, cv::Size(), spread);
  // An edge is about three pixels wide and runs all round; the blur spreads a vote over 2 pi
  // spread^2 cells, and real votes fall twice as wide as the blur.
  const double full =
      3.0 * 2.0 * std::numbers::pi * (radius / cell) / (4.0 * std::numbers::pi * spread * spread);

  // 3. Maxima no closer than 0.45 radii to a stronger one
  const int reach = std::max(1, static_cast<int>(0.45 * radius / cell));
  cv::Mat highest;
  cv::dilate(
      votes, highest, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  std::vector<BallCandidate> candidates;
  for (int j = 1; j + 1 < rows; ++j) {
    for (int i = 1; i + 1 < columns; ++i) {
      const float here = votes.at<float>(j, i);
      if (here <= 0.05 * full || here < highest.at<float>(j, i)) continue;
      candidates.push_back({region.left + i * cell, region.top - j * cell, here / full});
    }
  }
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const BallCandidate& a, const BallCandidate& b) {
        return a.votes > b.votes;
      });
  if (candidates.size() > static_cast<std::size_t>(most))
    candidates.resize(static_cast<std::size_t>(most));
  return candidates;
}

}  // namespace graintruth::tracking
