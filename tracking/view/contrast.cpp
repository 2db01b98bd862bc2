#include "tracking/view/contrast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tracking/median.h"

namespace graintruth::tracking {

LearnedContrast learn_contrast(const cv::Mat& full, const cv::Mat& empty, const cv::Mat& mask) {
  // More than noise and flicker change, less than any plate against a ground that shows it
  constexpr float least_change = 30.0F;  // grey levels, all three channels together
  std::array<std::vector<float>, 3> ground, change;
  std::size_t inside = 0;
  for (int row = 0; row < full.rows; ++row) {
    const auto* before = full.ptr<cv::Vec3b>(row);
    const auto* after = empty.ptr<cv::Vec3b>(row);
    const auto* use = mask.ptr<std::uint8_t>(row);
    for (int column = 0; column < full.cols; ++column) {
      if (!use[column]) continue;
      ++inside;
      float sum = 0.0F;
      for (int c = 0; c < 3; ++c)
        sum += std::abs(static_cast<float>(before[column][c]) - after[column][c]);
      if (sum < least_change) continue;
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        ground[channel].push_back(after[column][c]);
        change[channel].push_back(static_cast<float>(before[column][c]) - after[column][c]);
      }
    }
  }
  LearnedContrast learned;
  learned.changed =
      inside > 0 ? static_cast<double>(change[0].size()) / static_cast<double>(inside) : 0.0;
  if (change[0].empty()) return learned;
  Eigen::Vector3f typical;
  for (std::size_t c = 0; c < 3; ++c) {
    typical[static_cast<Eigen::Index>(c)] = median(change[c]);
    learned.contrast.ground[static_cast<Eigen::Index>(c)] = median(ground[c]);
  }
  learned.contrast.gain = typical.norm();
  if (learned.contrast.gain > 0.0F) learned.contrast.direction = typical / learned.contrast.gain;
  return learned;
}

cv::Mat1f contrast_of(const cv::Mat& frame, const cv::Rect& region, const Contrast& contrast) {
  // d . (colour - ground); a table a channel is faster than products and gives the same sums
  std::array<std::array<float, 256>, 3> table;
  for (int c = 0; c < 3; ++c)
    for (int level = 0; level < 256; ++level)
      table[static_cast<std::size_t>(c)][static_cast<std::size_t>(level)] =
          contrast.direction[c] * (static_cast<float>(level) - contrast.ground[c]);
  cv::Mat1f result(region.height, region.width);
  for (int row = 0; row < region.height; ++row) {
    const auto* from = frame.ptr<cv::Vec3b>(region.y + row) + region.x;
    float* to = result.ptr<float>(row);
    for (int column = 0; column < region.width; ++column)
      to[column] =
          table[0][from[column][0]] + table[1][from[column][1]] + table[2][from[column][2]];
  }
  return result;
}

}  // namespace graintruth::tracking
