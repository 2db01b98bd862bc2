#include "tracking/stagnant.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace graintruth::tracking {

namespace {

constexpr int moved_level = 24;        // grey levels of change at a pixel: well above camera noise
constexpr long fewest = 2000;          // moved pixels
constexpr double still_ratio = 3.0;    // over the change that noise and codec make at rest
constexpr double covered_share = 0.3;  // of the usual contrast: gaps between plates average out

}  // namespace

void SharpnessWatcher::add(const cv::Mat& frame) {
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  if (first_.empty()) first_ = grey;
  for (int row = 1; !previous_.empty() && row + 1 < grey.rows; row += 2) {
    const auto* now = grey.ptr<std::uint8_t>(row);
    const auto* before = previous_.ptr<std::uint8_t>(row);
    for (int column = 1; column + 1 < grey.cols; column += 2) {
      if (std::abs(now[column] - before[column]) < moved_level) continue;
      const auto steepness = [&](const cv::Mat& picture) {
        return std::abs(picture.at<std::uint8_t>(row + 1, column) -
                        picture.at<std::uint8_t>(row - 1, column)) +
               std::abs(picture.at<std::uint8_t>(row, column + 1) -
                        picture.at<std::uint8_t>(row, column - 1));
      };
      moving_ += steepness(grey);
      resting_ += steepness(first_);
      ++moved_;
    }
  }
  previous_ = grey;
}

double SharpnessWatcher::sharpness() const {
  return moved_ < fewest || resting_ == 0.0 ? 1.0 : moving_ / resting_;
}

StagnantWatcher::StagnantWatcher(const BedScene& scene)
    : scene_(scene), step_(0.5 * scene.shape.semi_minor) {
  const datasets::FlatBin& bin = *scene.experiment.rig.bin;
  const int columns = std::max(1, static_cast<int>(bin.width / (2.0 * step_)));
  for (int i = 0; i < columns; ++i) x_.push_back(bin.width * ((i + 0.5) / columns - 0.5));
  const double top = scene.film.calibration.camera
                         .unproject({scene.region.x + 0.5 * scene.region.width,
                                     static_cast<double>(scene.region.y)})
                         .y();
  rows_ = std::max(1, static_cast<int>(std::min(top, bin.height) / step_));
}

void StagnantWatcher::add(const cv::Mat& frame) {
  const cv::Mat1f contrast = contrast_of(frame, scene_.region, scene_.contrast);
  const int side = std::max(3, static_cast<int>(scene_.shape.semi_minor / scene_.pixel()));
  cv::Mat1f change = cv::Mat1f::zeros(contrast.size()), cover;
  if (!previous_.empty()) {
    cv::absdiff(contrast, previous_, change);
  } else {
    // What a shift by one pixel would change
    cv::absdiff(contrast.rowRange(1, contrast.rows),
                contrast.rowRange(0, contrast.rows - 1),
                change.rowRange(1, contrast.rows));
  }
  cv::boxFilter(change, change, CV_32F, {side, side});
  cv::boxFilter(contrast, cover, CV_32F, {2 * side, 2 * side});
  previous_ = contrast;
  Cells cells;
  for (const double x : x_) {
    for (int row = 0; row < rows_; ++row) {
      const Eigen::Vector2d at = scene_.film.calibration.camera.project(x, (row + 0.5) * step_);
      const int i =
          std::clamp(static_cast<int>(std::lround(at.y())) - scene_.region.y, 0, contrast.rows - 1);
      const int j =
          std::clamp(static_cast<int>(std::lround(at.x())) - scene_.region.x, 0, contrast.cols - 1);
      cells.change.push_back(change(i, j));
      cells.cover.push_back(cover(i, j));
    }
  }
  frames_.push_back(std::move(cells));
}

StagnantBed StagnantWatcher::profile(int opened_at) const {
  // 1. What changes at rest
  const double covered = covered_share * scene_.contrast.gain;
  std::vector<float> rest;
  for (std::size_t k = 1; k < frames_.size() && static_cast<int>(k) < std::max(2, opened_at); ++k)
    for (std::size_t cell = 0; cell < frames_[k].change.size(); ++cell)
      if (frames_[k].cover[cell] > covered) rest.push_back(frames_[k].change[cell]);
  double usual = 1.0;
  if (!rest.empty()) {
    const auto high = rest.begin() + static_cast<std::ptrdiff_t>(rest.size() * 9 / 10);
    std::nth_element(rest.begin(), high, rest.end());
    usual = std::max(0.5, static_cast<double>(*high));
  }
  // What stays sharper than a pixel stands still to the eye
  std::vector<float> shifted;
  for (std::size_t cell = 0; cell < frames_[0].change.size(); ++cell)
    if (frames_[0].cover[cell] > covered) shifted.push_back(frames_[0].change[cell]);
  double limit = still_ratio * usual;
  if (!shifted.empty()) {
    const auto middle = shifted.begin() + static_cast<std::ptrdiff_t>(shifted.size() / 2);
    std::nth_element(shifted.begin(), middle, shifted.end());
    limit = std::max(limit, static_cast<double>(*middle));
  }
  // 2. Up from the floor as far as it is covered and still, in this frame and in the next
  const double edge = 0.5 * scene_.experiment.rig.bin->orifice_width;
  StagnantBed profile;
  profile.x = x_;
  for (std::size_t k = 0; k < frames_.size() && frames_.size() > 1; ++k) {
    const Cells& now = frames_[std::max<std::size_t>(k, 1)];
    const Cells& next = frames_[std::min(k + 1, frames_.size() - 1)];
    std::vector<double>& heights = profile.height.emplace_back();
    for (std::size_t i = 0; i < x_.size(); ++i) {
      if (std::abs(x_[i]) < edge) {
        heights.push_back(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      int row = 0;
      for (; row < rows_; ++row) {
        const std::size_t cell =
            i * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(row);
        const bool is_still = std::max(now.change[cell], next.change[cell]) < limit;
        if (!is_still || now.cover[cell] < covered) break;
      }
      heights.push_back(row * step_);
    }
  }
  return profile;
}

bool StagnantWatcher::is_still(const StagnantBed& profile,
                               std::size_t frame,
                               double x,
                               double z) const {
  const auto nearest =
      std::min_element(profile.x.begin(), profile.x.end(), [&](double a, double b) {
        return std::abs(a - x) < std::abs(b - x);
      });
  const double height =
      profile.height[frame][static_cast<std::size_t>(nearest - profile.x.begin())];
  return z < height;  // never over the orifice, where the height is NaN
}

}  // namespace graintruth::tracking
