#include "tracking/spots.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracking/assignment.h"

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
// the mean over a square of one diameter.
cv::Mat band_pass(const cv::Mat& picture, const SpotOptions& options) {
  cv::Mat exact, smooth, ground;
  picture.convertTo(exact, CV_32F);
  const int reach = 2 * static_cast<int>(4.0 * options.noise_px + 0.5) + 1;
  cv::GaussianBlur(
      exact, smooth, {reach, reach}, options.noise_px, options.noise_px, cv::BORDER_REPLICATE);
  cv::blur(exact,
           ground,
           {options.diameter_px, options.diameter_px},
           cv::Point(-1, -1),
           cv::BORDER_REPLICATE);
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

cv::Mat contrast_to_ground(const cv::Mat& frame, int diameter_px) {
  // A median of a large square is taken of a small picture.
  constexpr int small_diameter = 9;
  const double shrink = std::min(1.0, static_cast<double>(small_diameter) / diameter_px);
  cv::Mat small, ground;
  cv::resize(frame, small, {}, shrink, shrink, cv::INTER_AREA);
  const int width = 2 * static_cast<int>(1.5 * shrink * diameter_px) + 1;
  cv::medianBlur(small, ground, width);
  cv::resize(ground, ground, frame.size(), 0.0, 0.0, cv::INTER_LINEAR);
  cv::Mat difference;
  cv::absdiff(frame, ground, difference);
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

std::vector<std::vector<int>> link_spots(const std::vector<std::vector<Spot>>& frames,
                                         double reach_px,
                                         int memory) {
  constexpr double forbidden = 1.0e12;
  struct Track {
    std::vector<int> spots;
    Eigen::Vector2d place, step;
    int unseen = 0;
  };
  std::vector<Track> tracks;
  for (std::size_t frame = 0; frame < frames.size(); ++frame) {
    std::vector<std::size_t> waiting;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (tracks[i].unseen <= memory) waiting.push_back(i);
    }
    const std::vector<Spot>& spots = frames[frame];
    Eigen::MatrixXd cost(static_cast<Eigen::Index>(waiting.size()),
                         static_cast<Eigen::Index>(spots.size()));
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const Track& track = tracks[waiting[i]];
      const Eigen::Vector2d expected = track.place + (track.unseen + 1) * track.step;
      for (std::size_t j = 0; j < spots.size(); ++j) {
        const double distance = (spots[j].pixel - expected).norm();
        cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            distance > reach_px * (track.unseen + 1) ? forbidden : distance * distance;
      }
    }
    const std::vector<int> of_track = waiting.empty() || spots.empty()
                                          ? std::vector<int>(waiting.size(), -1)
                                          : assign(cost, forbidden);
    std::vector<bool> taken(spots.size(), false);
    for (Track& track : tracks) track.spots.push_back(-1);
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      Track& track = tracks[waiting[i]];
      if (of_track[i] < 0) {
        ++track.unseen;
        continue;
      }
      const auto spot = static_cast<std::size_t>(of_track[i]);
      const bool has_step = frame > 0;
      if (has_step) track.step = (spots[spot].pixel - track.place) / (track.unseen + 1);
      track.place = spots[spot].pixel;
      track.unseen = 0;
      track.spots.back() = of_track[i];
      taken[spot] = true;
    }
    for (std::size_t j = 0; j < spots.size(); ++j) {
      if (taken[j]) continue;
      tracks.push_back({std::vector<int>(frame + 1, -1), spots[j].pixel, Eigen::Vector2d::Zero()});
      tracks.back().spots.back() = static_cast<int>(j);
    }
  }
  std::vector<std::vector<int>> result;
  for (Track& track : tracks) result.push_back(std::move(track.spots));
  return result;
}

}  // namespace graintruth::tracking
