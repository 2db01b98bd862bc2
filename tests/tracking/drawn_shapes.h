// Pictures of flat shapes with known places, drawn four times as fine as they are kept, for films
// of discs, rods and plates.
#pragma once

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace graintruth::tracking {

class Canvas {
 public:
  Canvas(int width, int height, const cv::Scalar& ground)
      : fine_(height * finer, width * finer, CV_8UC3, ground) {}

  // Corners in pixels of the picture, integers at pixel centres.
  void fill(const std::vector<Eigen::Vector2d>& corners, const cv::Scalar& colour) {
    constexpr int shift = 6;
    std::vector<cv::Point> points;
    for (const Eigen::Vector2d& corner : corners) {
      const Eigen::Vector2d at = (corner.array() + 0.5) * finer - 0.5;
      points.emplace_back(static_cast<int>(std::lround(at.x() * (1 << shift))),
                          static_cast<int>(std::lround(at.y() * (1 << shift))));
    }
    cv::fillPoly(fine_, std::vector{points}, colour, cv::LINE_8, shift);
  }

  // An ellipse by its half axes, turned counter-clockwise as one sees the picture.
  void ellipse(const Eigen::Vector2d& centre,
               double major,
               double minor,
               double angle,
               const cv::Scalar& colour) {
    constexpr int points = 90;
    std::vector<Eigen::Vector2d> outline;
    for (int k = 0; k < points; ++k) {
      const double around = 2.0 * CV_PI * k / points;
      outline.push_back(centre + turned(major * std::cos(around), minor * std::sin(around), angle));
    }
    fill(outline, colour);
  }

  void bar(const Eigen::Vector2d& centre,
           double length,
           double width,
           double angle,
           const cv::Scalar& colour) {
    std::vector<Eigen::Vector2d> corners;
    for (const auto& [along, across] : {std::pair(1, 1), {-1, 1}, {-1, -1}, {1, -1}})
      corners.push_back(centre + turned(0.5 * along * length, 0.5 * across * width, angle));
    fill(corners, colour);
  }

  // As a camera with a lens of 0.6 px and some noise sees it.
  cv::Mat picture(double noise, unsigned seed) const {
    cv::Mat picture, grains(fine_.rows / finer, fine_.cols / finer, CV_32FC3);
    cv::resize(fine_, picture, grains.size(), 0.0, 0.0, cv::INTER_AREA);
    picture.convertTo(picture, CV_32FC3);
    cv::GaussianBlur(picture, picture, {7, 7}, 0.6);
    cv::RNG generator(seed + 1);
    generator.fill(grains, cv::RNG::NORMAL, 0.0, noise);
    picture += grains;
    picture.convertTo(picture, CV_8UC3);
    return picture;
  }

 private:
  static constexpr int finer = 4;

  static Eigen::Vector2d turned(double along, double across, double angle) {
    return {std::cos(angle) * along - std::sin(angle) * across,
            -std::sin(angle) * along - std::cos(angle) * across};
  }

  cv::Mat fine_;
};

}  // namespace graintruth::tracking
