#include "tracking/view/edge_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace graintruth::tracking {

namespace {
constexpr double saturation = 250.0;  // grey levels of 255
}

EdgeImage::EdgeImage(const cv::Mat& frame, const cv::Rect& region, double blur_px)
    : EdgeImage(frame(region & cv::Rect(0, 0, frame.cols, frame.rows)),
                (region & cv::Rect(0, 0, frame.cols, frame.rows)).tl(),
                blur_px) {}

EdgeImage::EdgeImage(const cv::Mat& part, const cv::Point& corner, double blur_px)
    : region_(corner, part.size()) {
  cv::Mat exact, parts[3];
  part.convertTo(exact, CV_32FC3);
  cv::cvtColor(exact, exact, cv::COLOR_BGR2YCrCb);
  cv::split(exact, parts);
  // Films store colour at half the resolution and decoders repeat it in blocks of 2 x 2: without
  // more smoothing than the brightness needs, edges of colour would step with the blocks by half a
  // pixel.
  constexpr double colour_blur_px = 1.4;
  cv::GaussianBlur(parts[0], parts[0], cv::Size(5, 5), blur_px, blur_px, cv::BORDER_REPLICATE);
  for (int c : {1, 2}) {
    parts[c] -= 0.5;  // grey, in floating point
    cv::GaussianBlur(
        parts[c], parts[c], cv::Size(9, 9), colour_blur_px, colour_blur_px, cv::BORDER_REPLICATE);
  }
  cv::merge(parts, 3, smooth_);
  cv::inRange(
      part, cv::Scalar(saturation, saturation, saturation), cv::Scalar(255, 255, 255), saturated_);
  cv::dilate(saturated_, saturated_, cv::Mat::ones(5, 5, CV_8U));
}

bool EdgeImage::contains(const Eigen::Vector2d& pixel, double margin) const {
  return pixel.x() > region_.x + margin && pixel.y() > region_.y + margin &&
         pixel.x() < region_.x + region_.width - 1 - margin &&
         pixel.y() < region_.y + region_.height - 1 - margin;
}

double camera_noise(const cv::Mat& frame) {
  cv::Mat channel, response;
  cv::extractChannel(frame, channel, 1);
  // The difference of two Laplacians answers neither to slopes nor to plain edges; its gain on
  // white noise is 6.
  const cv::Mat kernel = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::filter2D(channel, response, CV_32F, kernel);
  std::vector<float> magnitudes;
  magnitudes.reserve(response.total() / 4 + 1);
  for (int row = 1; row + 1 < response.rows; row += 2)
    for (int column = 1; column + 1 < response.cols; column += 2)
      magnitudes.push_back(std::abs(response.at<float>(row, column)));
  if (magnitudes.empty()) return 1.0;
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  constexpr double normal_quartile = 0.6745;
  // Rounding to whole grey levels alone gives 0.29.
  return std::max(0.3, *middle / 6.0 / normal_quartile);
}

void quieten(cv::Mat& frame, double noise) {
  constexpr double bearable = 3.0;  // grey levels
  if (noise <= bearable) return;
  // White noise of standard deviation n, smoothed by a Gaussian of width s: n / (2 sqrt(pi) s)
  const double width = std::min(noise / bearable / (2.0 * std::sqrt(std::numbers::pi)), 2.0);
  cv::GaussianBlur(frame, frame, cv::Size(), std::max(width, 0.5));
}

double edge_noise(const cv::Mat& frame, double noise) {
  // White noise of one channel, as brightness (0.67 of it), smoothed by 0.8 px (0.35) and differed
  // over a pixel (0.8): 0.19. Twice that, for noise that is not white.
  constexpr double left_by_smoothing = 0.4;
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  std::array<std::size_t, 256> histogram = {};
  for (int row = 0; row < grey.rows; ++row)
    for (int column = 0; column < grey.cols; ++column)
      ++histogram[grey.at<std::uint8_t>(row, column)];
  const auto level_below = [&](double share) {
    const auto wanted = static_cast<std::size_t>(share * static_cast<double>(grey.total()));
    std::size_t sum = 0;
    int level = 0;
    while (level < 255 && (sum += histogram[static_cast<std::size_t>(level)]) <= wanted) ++level;
    return level;
  };
  const double range = level_below(0.99) - level_below(0.01);
  const double compression = std::clamp(range / 128.0, 0.35, 1.0);
  return std::max(compression, left_by_smoothing * noise);
}

}  // namespace graintruth::tracking
