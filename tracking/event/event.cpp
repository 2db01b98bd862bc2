#include "tracking/event/event.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace graintruth::tracking {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double bilinear(const cv::Mat& grey, const Eigen::Vector2d& pixel) {
  const int x0 = static_cast<int>(pixel.x()), y0 = static_cast<int>(pixel.y());
  const double fx = pixel.x() - x0, fy = pixel.y() - y0;
  const std::uint8_t* top = grey.ptr<std::uint8_t>(y0) + x0;
  const std::uint8_t* bottom = grey.ptr<std::uint8_t>(y0 + 1) + x0;
  return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) +
         fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
}

bool is_inside(const cv::Mat& grey, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 1 && pixel.y() >= 1 && pixel.x() < grey.cols - 2 && pixel.y() < grey.rows - 2;
}

// Mean over the face's width of how much brighter it gets over a pixel downwards, at heights from
// `top` down in steps. Empty where the face leaves the picture.
std::vector<double> downward_gradient(const cv::Mat& grey,
                                      const Camera& camera,
                                      const datasets::MovingFace& face,
                                      double top,
                                      double step,
                                      int count) {
  const double width = face.right_x - face.left_x;
  // The ends are left out: there the face meets the walls.
  const double from = face.left_x + 0.06 * width, to = face.right_x - 0.06 * width;
  const int columns = std::clamp(
      static_cast<int>(0.5 * (to - from) * camera.scale(0.5 * (from + to), top)), 8, 200);
  std::vector<double> profile(static_cast<std::size_t>(count) + 2, 0.0);
  for (int c = 0; c < columns; ++c) {
    const double x = from + (to - from) * c / (columns - 1.0);
    // Straight over the few millimetres of the profile
    const Eigen::Vector2d first = camera.project(x, top + step);
    const Eigen::Vector2d last = camera.project(x, top - step * count);
    if (!is_inside(grey, first) || !is_inside(grey, last)) return {};
    for (std::size_t k = 0; k < profile.size(); ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(count + 1);
      profile[k] += bilinear(grey, first + share * (last - first)) / columns;
    }
  }
  std::vector<double> gradient(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] = profile[k + 2] - profile[k];
  return gradient;
}

}  // namespace

double FaceWatcher::measure(const cv::Mat& grey, const Camera& camera, double moment) {
  const bool first = record_.time.empty();
  record_.time.push_back(moment / frame_rate_);
  const double reference = first ? face_.face_z : last_height_;
  const double pixel = 1.0 / camera.scale(0.5 * (face_.left_x + face_.right_x), reference);  // m
  const double step = 0.5 * pixel;
  // First frame: the rig was measured to some millimetres, and the front edge of a deep face shows
  // parallax. Later: a frame's travel, and as much again for every frame in which it was not seen.
  const double travel = face_.velocity_z / frame_rate_ * (moment - last_seen_);
  constexpr double rig_tolerance = 5.0e-3;  // m
  const double up = first ? rig_tolerance : 2.0 * pixel + std::max(0.0, 1.3 * travel);
  const double down = first ? rig_tolerance : 2.0 * pixel + std::max(0.0, -1.3 * travel);
  const int count = static_cast<int>((up + down) / step) + 1;
  const std::vector<double> gradient =
      downward_gradient(grey, camera, face_, reference + up, step, count);
  double height = nan;
  if (gradient.size() >= 3) {
    std::size_t best = 0;
    double strongest = 0.0;
    for (std::size_t k = 1; k + 1 < gradient.size(); ++k) {
      const double value = sign_ == 0.0 ? std::abs(gradient[k]) : sign_ * gradient[k];
      if (value > strongest) {
        strongest = value;
        best = k;
      }
    }
    const double needed =
        sign_ == 0.0 ? 2.0 : 0.4 * strength_;  // grey levels a pixel, mean over the width
    if (strongest > needed) {
      const double before = gradient[best - 1], here = gradient[best], after = gradient[best + 1];
      const double curvature = before - 2.0 * here + after;
      const double offset =
          curvature != 0.0 ? std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) : 0.0;
      height = reference + up - (static_cast<double>(best) + offset) * step;
      if (sign_ == 0.0) {
        sign_ = here > 0.0 ? 1.0 : -1.0;
        strength_ = strongest;
      }
      // Light and contact change slowly
      strength_ += 0.05 * (strongest - strength_);
    }
  }
  if (std::isfinite(height)) {
    last_height_ = height;
    last_seen_ = moment;
  } else if (first) {
    last_height_ = face_.face_z;
  }
  record_.height.push_back(height);
  return height;
}

std::optional<Event> fit_onset(const HeightRecord& record, double expected_speed) {
  struct Sample {
    double time, height;
  };
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < record.time.size(); ++i)
    if (std::isfinite(record.height[i])) samples.push_back({record.time[i], record.height[i]});
  constexpr std::size_t fewest = 8;
  if (samples.size() < fewest || expected_speed == 0.0) return std::nullopt;
  const double interval =
      (record.time.back() - record.time.front()) / static_cast<double>(record.time.size() - 1);
  constexpr double span = 1.0;          // s after the onset
  constexpr double speed_prior = 0.02;  // relative

  // Solves for z0 and v at a given t0; both enter linearly. Returns the robust cost.
  struct Line {
    double z0 = 0.0, v = 0.0, cost = std::numeric_limits<double>::infinity(), scatter = 0.0;
    int still = 0, moving = 0;
  };
  const auto fit_at = [&](double t0, double sigma) {
    Line line;
    line.v = expected_speed;
    std::vector<double> heights;
    for (int round = 0; round < 4; ++round) {
      Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      const double prior = std::pow(sigma / (speed_prior * expected_speed), 2);
      normal(1, 1) += prior;
      right(1) += prior * expected_speed;
      line.cost = 0.0;
      line.still = line.moving = 0;
      for (const Sample& s : samples) {
        if (s.time > t0 + span) break;
        const double after = std::max(0.0, s.time - t0);
        (after > 0.0 ? line.moving : line.still) += 1;
        const double miss = round == 0 ? 0.0 : (s.height - line.z0 - line.v * after) / sigma;
        const double weight = 1.0 / (1.0 + miss * miss / 9.0);  // Cauchy: three sigma counts half
        line.cost += round == 0 ? 0.0 : 9.0 * std::log1p(miss * miss / 9.0);
        const Eigen::Vector2d row(1.0, after);
        normal += weight * row * row.transpose();
        right += weight * row * s.height;
      }
      const Eigen::Vector2d solution = normal.ldlt().solve(right);
      line.z0 = solution[0];
      line.v = solution[1];
    }
    // Later onsets keep more frames: compare by the mean.
    line.cost /= std::max(1, line.still + line.moving);
    return line;
  };

  double sigma = 0.25 * std::abs(expected_speed) * interval;  // m; replaced by the scatter found
  double best_time = 0.0;
  Line best;
  for (int round = 0; round < 3; ++round) {
    best = Line{};
    const double last = samples.back().time;
    const double step = round == 0 ? 0.5 * interval : 0.02 * interval;
    const double from = round == 0 ? samples.front().time : best_time - 1.5 * interval;
    const double to = round == 0 ? last : best_time + 1.5 * interval;
    double chosen = best_time;
    for (double t0 = from; t0 <= to; t0 += step) {
      const Line line = fit_at(t0, sigma);
      if (line.moving < 4) continue;
      if (line.cost < best.cost) {
        best = line;
        chosen = t0;
      }
    }
    best_time = chosen;
    if (!std::isfinite(best.cost)) return std::nullopt;
    std::vector<double> misses;
    for (const Sample& s : samples) {
      if (s.time > best_time + span) break;
      misses.push_back(std::abs(s.height - best.z0 - best.v * std::max(0.0, s.time - best_time)));
    }
    std::nth_element(misses.begin(),
                     misses.begin() + static_cast<std::ptrdiff_t>(misses.size() / 2),
                     misses.end());
    sigma =
        std::max(misses[misses.size() / 2] / 0.6745, 1.0e-3 * std::abs(expected_speed) * interval);
  }
  // It must really have stood still and then moved at about the stated speed: most samples of both
  // parts near the line.
  int still_near = 0, moving_near = 0;
  for (const Sample& s : samples) {
    if (s.time > best_time + span) break;
    const double after = std::max(0.0, s.time - best_time);
    const bool near = std::abs(s.height - best.z0 - best.v * after) <
                      std::max(5.0 * sigma, 0.1 * std::abs(expected_speed) * interval);
    (after > 0.0 ? moving_near : still_near) += near;
  }
  // A clock wrong by a factor of two is told of; a slower drift than that is no face.
  const double speed_ratio = best.v / expected_speed;
  if (best.still < 2 || 2 * still_near < best.still || 2 * moving_near < best.moving ||
      speed_ratio < 0.45 || speed_ratio > 2.2 || sigma > std::abs(expected_speed) * interval)
    return std::nullopt;

  // Covariance of (z0, v, t0); dz/dt0 = -v after the onset. Neighbouring frames err alike (the same
  // pixels, the same compression), hence the factor two.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  normal(1, 1) += std::pow(sigma / (speed_prior * expected_speed), 2);
  for (const Sample& s : samples) {
    if (s.time > best_time + span) break;
    const double after = std::max(0.0, s.time - best_time);
    const Eigen::Vector3d row(1.0, after, after > 0.0 ? -best.v : 0.0);
    normal += row * row.transpose();
  }
  Event event;
  event.time = best_time;
  event.speed = best.v;
  event.scatter = sigma;
  event.uncertainty = std::hypot(2.0 * sigma * std::sqrt(normal.inverse()(2, 2)), 0.02 * interval);
  event.how = "piston face";
  return event;
}

}  // namespace graintruth::tracking
