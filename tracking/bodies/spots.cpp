#include "tracking/bodies/spots.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

// Offsets inside a disc of the radius.
std::vector<cv::Point> disc(int radius) {
  std::vector<cv::Point> offsets;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      if (x * x + y * y <= radius * radius) offsets.emplace_back(x, y);
    }
  }
  return offsets;
}

// What is larger than the noise and smaller than the particle: smoothed by the noise's width, less
// the mean over a square about it.
cv::Mat band_pass(const cv::Mat& picture, const SpotOptions& options) {
  cv::Mat exact, smooth, ground;
  picture.convertTo(exact, CV_32F);
  const int reach = 2 * static_cast<int>(4.0 * options.noise_px + 0.5) + 1;
  cv::GaussianBlur(
      exact, smooth, {reach, reach}, options.noise_px, options.noise_px, cv::BORDER_REPLICATE);
  const int square = options.ground_px > 0 ? options.ground_px : options.diameter_px;
  cv::blur(exact, ground, {square, square}, cv::Point(-1, -1), cv::BORDER_REPLICATE);
  cv::Mat band = smooth - ground;
  return cv::max(band, 0.0);
}

double percentile_above_zero(const cv::Mat& band, double percentile) {
  std::vector<float> values;
  for (int row = 0; row < band.rows; ++row) {
    for (int column = 0; column < band.cols; ++column) {
      if (band.at<float>(row, column) > 0.0F) values.push_back(band.at<float>(row, column));
    }
  }
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(
                                       percentile / 100.0 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Centroid {
  Eigen::Vector2d shift;
  double mass = 0.0;
};

Centroid centroid(const cv::Mat& band, const cv::Point& at, const std::vector<cv::Point>& mask) {
  Centroid result{Eigen::Vector2d::Zero()};
  for (const cv::Point& offset : mask) {
    const double value = band.at<float>(at + offset);
    result.mass += value;
    result.shift += value * Eigen::Vector2d(offset.x, offset.y);
  }
  if (result.mass > 0.0) result.shift /= result.mass;
  return result;
}

}  // namespace

cv::Mat local_ground(const cv::Mat& frame, int diameter_px) {
  // A median of a large square is taken of a small picture.
  constexpr int small_diameter = 9;
  const double shrink = std::min(1.0, static_cast<double>(small_diameter) / diameter_px);
  cv::Mat small, ground;
  cv::resize(frame, small, {}, shrink, shrink, cv::INTER_AREA);
  const int width = 2 * static_cast<int>(1.5 * shrink * diameter_px) + 1;
  cv::medianBlur(small, ground, width);
  cv::resize(ground, ground, frame.size(), 0.0, 0.0, cv::INTER_LINEAR);
  return ground;
}

cv::Mat contrast_to_ground(const cv::Mat& frame, int diameter_px) {
  cv::Mat difference;
  cv::absdiff(frame, local_ground(frame, diameter_px), difference);
  difference.convertTo(difference, CV_32F);
  std::vector<cv::Mat> channels;
  cv::split(difference, channels);
  cv::Mat square = cv::Mat::zeros(frame.size(), CV_32F);
  for (const cv::Mat& channel : channels) square += channel.mul(channel);
  cv::Mat contrast;
  cv::sqrt(square, contrast);
  return contrast;
}

double gap_in_masses(const std::vector<Spot>& spots, int diameter_px) {
  // What one grey level all over the spot makes: below it nothing can be told apart.
  const double least = static_cast<double>(disc(diameter_px / 2).size());
  std::vector<double> logs;
  for (const Spot& spot : spots) logs.push_back(std::log(std::max(spot.mass, least)));
  logs.push_back(std::log(least));
  std::sort(logs.begin(), logs.end());
  double widest = 0.0, middle = logs.front();
  for (std::size_t i = 1; i < logs.size(); ++i) {
    if (logs[i] - logs[i - 1] <= widest) continue;
    widest = logs[i] - logs[i - 1];
    middle = 0.5 * (logs[i] + logs[i - 1]);
  }
  return std::exp(middle);
}

std::vector<Spot> locate_spots(const cv::Mat& picture, const SpotOptions& options) {
  const cv::Mat band = band_pass(picture, options);
  const int radius = options.diameter_px / 2;

  // 1. Maxima over a disc of one diameter, clear of the border
  const std::vector<cv::Point> mask = disc(radius);
  cv::Mat highest;
  cv::dilate(band, highest, cv::Mat());
  const double least = percentile_above_zero(band, options.percentile);
  std::vector<cv::Point> maxima;
  for (int row = radius; row < band.rows - radius; ++row) {
    for (int column = radius; column < band.cols - radius; ++column) {
      const float value = band.at<float>(row, column);
      if (!(value > least) || value != highest.at<float>(row, column)) continue;
      const cv::Point at(column, row);
      if (std::none_of(mask.begin(), mask.end(), [&](const cv::Point& offset) {
            return band.at<float>(at + offset) > value;
          }))
        maxima.push_back(at);
    }
  }

  // 2. Centre of mass in a disc that moves to it
  std::vector<Spot> spots;
  for (cv::Point at : maxima) {
    Centroid now = centroid(band, at, mask);
    constexpr int most_moves = 10;
    constexpr double far_off = 0.6;  // px; from here on the next pixel is the better middle
    for (int move = 0; move < most_moves; ++move) {
      const cv::Point step(now.shift.x() > far_off    ? 1
                           : now.shift.x() < -far_off ? -1
                                                      : 0,
                           now.shift.y() > far_off    ? 1
                           : now.shift.y() < -far_off ? -1
                                                      : 0);
      if (step == cv::Point()) break;
      at += step;
      at.x = std::clamp(at.x, radius, band.cols - radius - 1);
      at.y = std::clamp(at.y, radius, band.rows - radius - 1);
      now = centroid(band, at, mask);
    }
    spots.push_back({Eigen::Vector2d(at.x, at.y) + now.shift, now.mass});
  }

  // 3. Particles, strongest first, none within a diameter of a stronger one
  std::sort(
      spots.begin(), spots.end(), [](const Spot& a, const Spot& b) { return a.mass > b.mass; });
  const double least_mass =
      options.least_mass > 0.0 ? options.least_mass : gap_in_masses(spots, options.diameter_px);
  std::vector<Spot> kept;
  for (const Spot& spot : spots) {
    if (spot.mass < least_mass) break;
    const bool taken = std::any_of(kept.begin(), kept.end(), [&](const Spot& other) {
      return (other.pixel - spot.pixel).norm() < options.diameter_px;
    });
    if (!taken) kept.push_back(spot);
  }
  return kept;
}

std::vector<double> centre_on_discs(const cv::Mat& contrast,
                                    double diameter_px,
                                    double noise,
                                    std::vector<Spot>& spots) {
  const std::vector<Spot> first = spots;
  const double reach = 0.5 * diameter_px + 2.0;  // and the blur of its rim
  const auto box_half = static_cast<int>(reach) + 1;
  const cv::Rect whole({}, contrast.size());
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    std::vector<Eigen::Vector2d> others;
    for (const Spot& other : first) {
      const double apart = (other.pixel - first[i].pixel).norm();
      if (apart > 0.0 && apart < 2.0 * reach) others.push_back(other.pixel);
    }
    Eigen::Vector2d& centre = spots[i].pixel;
    double level = 0.0;
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
      const cv::Point middle(static_cast<int>(std::lround(centre.x())),
                             static_cast<int>(std::lround(centre.y())));
      const cv::Rect box =
          cv::Rect(middle.x - box_half, middle.y - box_half, 2 * box_half + 1, 2 * box_half + 1) &
          whole;
      // 1. Half of what its inner part stands out by
      std::vector<float> inner;
      const auto is_own = [&](const Eigen::Vector2d& at, double own) {
        return std::all_of(others.begin(), others.end(), [&](const Eigen::Vector2d& other) {
          return (at - other).norm() > own;
        });
      };
      for (int row = box.y; row < box.br().y; ++row)
        for (int column = box.x; column < box.br().x; ++column)
          if (std::hypot(column - centre.x(), row - centre.y()) < 0.35 * diameter_px)
            inner.push_back(contrast.at<float>(row, column));
      if (inner.empty()) break;
      const double floor = 3.0 * noise;  // of three channels together
      level = std::max(noise, 0.5 * static_cast<double>(median(inner)) - floor);
      // 2. Its centre of area
      double area = 0.0;
      Eigen::Vector2d moment = Eigen::Vector2d::Zero();
      for (int row = box.y; row < box.br().y; ++row) {
        for (int column = box.x; column < box.br().x; ++column) {
          const Eigen::Vector2d at(column, row);
          const double own = (at - centre).norm();
          if (own > reach || !is_own(at, own)) continue;
          const double share =
              std::clamp((contrast.at<float>(row, column) - floor) / level, 0.0, 1.0);
          area += share;
          moment += share * (at - centre);
        }
      }
      if (area <= 0.0) break;
      const Eigen::Vector2d step = moment / area;
      centre += step;
      constexpr double settled = 1.0e-3;  // px
      if (step.norm() < settled) break;
    }
    // Only pixels of the rim, about a pixel and a half wide, are neither in nor out: each errs by
    // n / level, d / sqrt(8) away from the centre in an axis. Over the area pi d^2 / 4:
    //   sigma^2 = 1.5 pi d (n / level)^2 (d^2 / 8) / (pi d^2 / 4)^2
    const double share = level > 0.0 ? noise / level : 1.0;
    sigmas.push_back(share * std::sqrt(3.0 / (std::numbers::pi * diameter_px)));
  }
  return sigmas;
}

std::size_t particles_among(const std::vector<Spot>& spots, int count) {
  const std::size_t most = std::min(spots.size(), static_cast<std::size_t>(count));
  // Films that show less than half of them are not read by their masses
  double widest = 2.0;
  std::size_t among = most;
  for (std::size_t i = std::max<std::size_t>(1, most / 2); i < most; ++i) {
    const double ratio = spots[i - 1].mass / spots[i].mass;
    if (ratio <= widest) continue;
    widest = ratio;
    among = i;
  }
  return among;
}

}  // namespace graintruth::tracking
