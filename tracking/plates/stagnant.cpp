#include "tracking/plates/stagnant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr int moved_level = 24;        // grey levels of change at a pixel: well above camera noise
constexpr long fewest = 2000;          // moved pixels
constexpr double covered_share = 0.4;  // of the usual contrast: gaps between plates average out
constexpr double window_share = 0.8;   // of a diameter: holds edges in all directions

// The smaller eigenvalue of the symmetric matrix (xx, xz; xz, zz).
float smaller_eigenvalue(float xx, float xz, float zz) {
  return 0.5F * (xx + zz) - std::hypot(0.5F * (xx - zz), xz);
}

double diameter_of(const PlateShape& shape) {
  return 2.0 * std::sqrt(shape.semi_major * shape.semi_minor);
}

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

StagnantWatcher::StagnantWatcher(const BedScene& scene) : scene_(scene), pixel_(scene.pixel()) {
  const datasets::OpenBox& box = scene.box();
  const double diameter = diameter_of(scene.shape);
  const Camera& camera = scene.film.calibration.camera;
  const Eigen::Vector2d top_of_picture(scene.region.x + 0.5 * scene.region.width, scene.region.y);
  const double height = std::min(camera.unproject(top_of_picture).y(), box.height);
  places_ = datasets::make_stagnant_map(box.width, height, diameter);
  window_ = std::max(3, static_cast<int>(std::lround(window_share * diameter / pixel_)));
  step_ = datasets::stagnant_speed(diameter, scene.spec.rig.gravity) / scene.spec.camera.frame_rate;
  apart_ = std::max(1, static_cast<int>(std::ceil(pixel_ / step_)));
  const cv::Size size(static_cast<int>(box.width / pixel_), static_cast<int>(height / pixel_));
  column_of_.create(size);
  row_of_.create(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const Eigen::Vector2d at =
          camera.project((column + 0.5) * pixel_ - 0.5 * box.width, (row + 0.5) * pixel_);
      column_of_(row, column) = static_cast<float>(at.x() - scene.region.x);
      row_of_(row, column) = static_cast<float>(at.y() - scene.region.y);
    }
  }
}

void StagnantWatcher::add(const cv::Mat& frame, int parity) {
  cv::Mat1f picture;
  cv::remap(contrast_of(frame, scene_.region, scene_.contrast),
            picture,
            column_of_,
            row_of_,
            cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  if (frames_.empty()) {
    if (parity >= 0 && apart_ % 2 != 0) ++apart_;
    first_picture_ = picture;
  }
  recent_.push_back(slopes_of(picture));
  if (frames_.empty()) first_ = recent_.back();
  if (recent_.size() > static_cast<std::size_t>(apart_) + 1) recent_.pop_front();
  Places places;
  cv::Mat1f cover;
  cv::boxFilter(picture, cover, CV_32F, {window_, window_});
  places.cover = at_places(cover);
  places.to_first = at_places(likeness(first_, recent_.back()));
  if (recent_.size() > static_cast<std::size_t>(apart_))
    places.to_earlier = at_places(likeness(recent_.front(), recent_.back()));
  frames_.push_back(std::move(places));
}

StagnantWatcher::Slopes StagnantWatcher::slopes_of(const cv::Mat1f& picture) const {
  Slopes slopes;
  const cv::Mat1f central = (cv::Mat1f(1, 3) << -0.5F, 0.0F, 0.5F);
  cv::filter2D(picture, slopes.along_x, CV_32F, central);
  cv::filter2D(picture, slopes.along_z, CV_32F, central.t());
  slopes.own = smaller_eigenvalues(slopes, slopes);
  return slopes;
}

// lambda_min of the window's sums of sym(a b^T)
cv::Mat1f StagnantWatcher::smaller_eigenvalues(const Slopes& a, const Slopes& b) const {
  const auto summed = [&](cv::Mat1f product) {
    cv::boxFilter(product, product, CV_32F, {window_, window_});
    return product;
  };
  const cv::Mat1f xx = summed(a.along_x.mul(b.along_x)), zz = summed(a.along_z.mul(b.along_z));
  const cv::Mat1f xz = summed(0.5F * (a.along_x.mul(b.along_z) + a.along_z.mul(b.along_x)));
  cv::Mat1f result(xx.size());
  for (int row = 0; row < result.rows; ++row)
    for (int column = 0; column < result.cols; ++column)
      result(row, column) = smaller_eigenvalue(xx(row, column), xz(row, column), zz(row, column));
  return result;
}

cv::Mat1f StagnantWatcher::likeness(const Slopes& a, const Slopes& b) const {
  cv::Mat1f result = smaller_eigenvalues(a, b);
  constexpr float least = 1.0e-3F;  // grey levels squared: where there is nothing at all
  for (int row = 0; row < result.rows; ++row)
    for (int column = 0; column < result.cols; ++column)
      result(row, column) /= std::sqrt(std::max(least, a.own(row, column) * b.own(row, column)));
  return result;
}

std::vector<float> StagnantWatcher::at_places(const cv::Mat1f& picture) const {
  std::vector<float> values;
  const double left = 0.5 * scene_.box().width;
  for (const double x : places_.x)
    for (const double z : places_.z)
      values.push_back(
          picture(std::clamp(static_cast<int>(z / pixel_), 0, picture.rows - 1),
                  std::clamp(static_cast<int>((x + left) / pixel_), 0, picture.cols - 1)));
  return values;
}

float StagnantWatcher::typical(const std::vector<float>& likeness, const Places& places) const {
  std::vector<float> of_covered;
  for (std::size_t i = 0; i < likeness.size(); ++i)
    if (is_covered(places, i)) of_covered.push_back(likeness[i]);
  return median(std::move(of_covered));
}

bool StagnantWatcher::is_covered(const Places& places, std::size_t place) const {
  return places.cover[place] > covered_share * scene_.contrast.gain;
}

// How like the first picture is to itself when it is shifted as far as a place may move.
double StagnantWatcher::shifted_likeness() const {
  constexpr int directions = 8;
  const double shift = step_ * apart_ / pixel_;
  std::vector<float> found;
  for (int k = 0; k < directions; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / directions;
    const cv::Mat1f by =
        (cv::Mat1f(2, 3) << 1.0, 0.0, shift * std::cos(angle), 0.0, 1.0, shift * std::sin(angle));
    cv::Mat1f shifted;
    cv::warpAffine(
        first_picture_, shifted, by, first_picture_.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    found.push_back(typical(at_places(likeness(first_, slopes_of(shifted))), frames_.front()));
  }
  return median(std::move(found));
}

float StagnantWatcher::limit() const {
  // Noise and codec make pictures at rest unlike each other, too: the stillest moment tells how
  // much
  float at_rest = 0.0F;
  for (const Places& places : frames_)
    if (!places.to_earlier.empty()) at_rest = std::max(at_rest, typical(places.to_earlier, places));
  return at_rest * static_cast<float>(shifted_likeness());
}

std::vector<datasets::StagnantMap> StagnantWatcher::maps() const {
  std::vector<datasets::StagnantMap> maps;
  const auto apart = static_cast<std::size_t>(apart_);
  if (frames_.size() <= apart) return maps;
  const float least = limit();
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const std::size_t from = std::min(k, frames_.size() - 1 - apart);
    const Places &before = frames_[from], &after = frames_[from + apart];
    datasets::StagnantMap& map = maps.emplace_back(places_);
    for (std::size_t i = 0; i < map.ground.size(); ++i) {
      if (!is_covered(before, i)) continue;
      const bool is_still = is_covered(after, i) && after.to_earlier[i] > least;
      map.ground[i] = is_still ? datasets::Ground::still : datasets::Ground::moving;
    }
  }
  return maps;
}

std::vector<std::size_t> StagnantWatcher::stay_until(
    const std::vector<Eigen::Vector2d>& centres) const {
  const auto nearest = [](const std::vector<double>& values, double value) {
    const auto least = std::min_element(values.begin(), values.end(), [&](double a, double b) {
      return std::abs(a - value) < std::abs(b - value);
    });
    return static_cast<std::size_t>(least - values.begin());
  };
  const float least = limit();
  std::vector<std::size_t> until;
  for (const Eigen::Vector2d& centre : centres) {
    const std::size_t place =
        nearest(places_.x, centre.x()) * places_.z.size() + nearest(places_.z, centre.y());
    std::size_t frame = 0;
    while (frame < frames_.size() && frames_[frame].to_first[place] > least) ++frame;
    until.push_back(frame);
  }
  return until;
}

}  // namespace graintruth::tracking
