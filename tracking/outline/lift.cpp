#include "tracking/outline/lift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Sample {
  double time, height;
};

// The best line z0 + v (t - t0) after t0, z0 before it.
struct Line {
  double z0 = 0.0, v = 0.0, cost = std::numeric_limits<double>::infinity();
};

Line line_from(const std::vector<Sample>& samples, double t0, double sigma) {
  Line line;
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    double cost = 0.0;
    for (const Sample& s : samples) {
      const double after = std::max(0.0, s.time - t0);
      const double miss = round == 0 ? 0.0 : (s.height - line.z0 - line.v * after) / sigma;
      const double weight = 1.0 / (1.0 + miss * miss / 9.0);
      cost += 9.0 * std::log1p(miss * miss / 9.0);
      const Eigen::Vector2d row(1.0, after);
      normal += weight * row * row.transpose();
      right += weight * row * s.height;
    }
    // Few moments after t0 leave the speed open
    if (!(std::abs(normal.determinant()) > 1.0e-12 * normal.squaredNorm())) return line;
    const Eigen::Vector2d solution = normal.ldlt().solve(right);
    line = {solution[0], solution[1], cost};
  }
  return line;
}

}  // namespace

std::optional<Lift> fit_lift(const HeightRecord& record, double drawn) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < record.time.size(); ++i)
    if (std::isfinite(record.height[i])) samples.push_back({record.time[i], record.height[i]});
  constexpr std::size_t fewest = 8;
  if (samples.size() < fewest) return std::nullopt;
  const double interval =
      (samples.back().time - samples.front().time) / static_cast<double>(samples.size() - 1);
  // Steps from moment to moment scatter as the heights do about any smooth motion
  std::vector<double> bends;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i)
    bends.push_back(
        std::abs(samples[i - 1].height - 2.0 * samples[i].height + samples[i + 1].height));
  double sigma = std::max(median(bends) / 0.6745 / std::sqrt(6.0), 1.0e-9);
  Line best;
  double start = samples.front().time;
  for (int round = 0; round < 3; ++round) {
    const double step = round == 0 ? interval : 0.02 * interval;
    const double from = round == 0 ? samples.front().time : start - 1.5 * interval;
    const double to = round == 0 ? samples[samples.size() - 4].time : start + 1.5 * interval;
    best = {};
    double chosen = start;
    for (double t0 = from; t0 <= to; t0 += step) {
      const Line line = line_from(samples, t0, sigma);
      if (line.cost >= best.cost) continue;
      best = line;
      chosen = t0;
    }
    start = chosen;
    std::vector<double> misses;
    for (const Sample& s : samples)
      misses.push_back(std::abs(s.height - best.z0 - best.v * std::max(0.0, s.time - start)));
    sigma = std::max(median(misses) / 0.6745, 1.0e-9);
  }
  Lift lift{.start = start, .speed = best.v, .from = best.z0, .scatter = sigma};
  const double travel = best.v * (samples.back().time - start);
  if (!(std::abs(travel) > 6.0 * sigma)) return std::nullopt;
  int still = 0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples) {
    const double after = std::max(0.0, s.time - start);
    still += after == 0.0 ? 1 : 0;
    const Eigen::Vector3d row(1.0, after, after > 0.0 ? -best.v : 0.0);
    normal += row * row.transpose();
  }
  lift.start_is_seen = still >= 2;
  // Neighbouring frames err alike (the same pixels, the same compression), hence the factor two
  if (lift.start_is_seen) {
    const Eigen::Matrix3d covariance = normal.inverse() * (4.0 * sigma * sigma);
    lift.speed_sigma = std::sqrt(covariance(1, 1));
    lift.start_sigma = std::hypot(std::sqrt(covariance(2, 2)), 0.02 * interval);
  } else {
    const Eigen::Matrix2d covariance =
        normal.topLeftCorner<2, 2>().inverse() * (4.0 * sigma * sigma);
    lift.speed_sigma = std::sqrt(covariance(1, 1));
    lift.start = start - (best.z0 - drawn) / best.v;
    lift.from = drawn;
    lift.start_sigma = std::hypot(std::sqrt(covariance(0, 0)) / std::abs(best.v), interval);
  }
  return lift;
}

LiftWatcher::LiftWatcher(const datasets::SeenOutline::Mover& mover,
                         const PlaneGrid& grid,
                         const Eigen::Vector3d& eye)
    : mover_(mover), grid_(grid), eye_(eye) {
  const Eigen::Vector2d& velocity = mover.velocity;
  if (std::abs(velocity.x()) > std::abs(velocity.y())) {
    way_ = velocity.x() > 0.0 ? Way::right : Way::left;
    for (Eigen::Vector2d& corner : mover_.drawing) corner = turned(corner);
    eye_.head<2>() = turned(eye.head<2>());
    const cv::Size size(grid.size().height, grid.size().width);
    const Eigen::Vector2d first =  // the corner that comes to lie at the upper left
        way_ == Way::right ? Eigen::Vector2d(grid.x(grid.size().width - 1), grid.z(0))
                           : Eigen::Vector2d(grid.x(0), grid.z(grid.size().height - 1));
    grid_ = PlaneGrid(turned(first).x(), turned(first).y(), grid.cell(), size);
  }
  double left = mover_.drawing.front().x(), right = left;
  double bottom = mover_.drawing.front().y(), top = bottom;
  for (const Eigen::Vector2d& corner : mover_.drawing) {
    left = std::min(left, corner.x());
    right = std::max(right, corner.x());
    bottom = std::min(bottom, corner.y());
    top = std::max(top, corner.y());
  }
  edges_[0].drawn = top;
  edges_[1].drawn = bottom;
  const double middle = 0.5 * (left + right), half = 0.5 * (right - left);
  const auto band = [&](double from, double to) {
    const int first =
        std::clamp(static_cast<int>(std::lround(grid_.column(from))), 0, grid_.size().width - 1);
    const int last =
        std::clamp(static_cast<int>(std::lround(grid_.column(to))), first, grid_.size().width - 1);
    bands_.emplace_back(first, last);
  };
  if (mover.radius > 0.0) {
    // Where a tube turns away from the eye little of it stands before the plane, but its very rim
    // is bright or dark by what it mirrors
    constexpr double from = 0.7, to = 0.92;
    band(middle - to * half, middle - from * half);
    band(middle + from * half, middle + to * half);
    constexpr int steps = 16;
    for (int i = 0; i < steps; ++i) {
      const double share = from + (to - from) * (i + 0.5) / steps;
      depth_ += mover.radius * std::sqrt(1.0 - share * share) / steps;
    }
  } else {
    band(middle - 0.8 * half, middle + 0.8 * half);
  }
}

// A quarter to the left for what goes right, which is then up; to the right for what goes left.
Eigen::Vector2d LiftWatcher::turned(const Eigen::Vector2d& point) const {
  if (way_ == Way::up) return point;
  return way_ == Way::right ? Eigen::Vector2d(-point.y(), point.x())
                            : Eigen::Vector2d(point.y(), -point.x());
}

Eigen::Vector2d LiftWatcher::turned_back(const Eigen::Vector2d& point) const {
  if (way_ == Way::up) return point;
  return way_ == Way::right ? Eigen::Vector2d(point.y(), -point.x())
                            : Eigen::Vector2d(-point.y(), point.x());
}

// Above the eye the near side of a rim is its upper outline, below the eye the far side; of the
// lower edge the other way round.
double LiftWatcher::rises_by(const Edge& edge, double row) const {
  const double seen = grid_.z(row) - eye_.y();
  const bool is_upper = &edge == edges_.data();
  const double before = (seen > 0.0) == is_upper ? depth_ : -depth_;  // m, before the plane
  return eye_.y() + seen * (eye_.z() - before) / eye_.z() - edge.drawn;
}

void LiftWatcher::look(const cv::Mat& grey, const cv::Mat1b& seen, double time) {
  if (way_ == Way::up) {
    look_upwards(grey, seen, time);
    return;
  }
  const int turn = way_ == Way::right ? cv::ROTATE_90_COUNTERCLOCKWISE : cv::ROTATE_90_CLOCKWISE;
  cv::Mat turned_grey, turned_seen;
  cv::rotate(grey, turned_grey, turn);
  cv::rotate(seen, turned_seen, turn);
  look_upwards(turned_grey, turned_seen, time);
}

void LiftWatcher::look_upwards(const cv::Mat& grey, const cv::Mat1b& seen, double time) {
  // 1. Brightness along z over the sides of the mover, and its change
  std::vector<double> profile(static_cast<std::size_t>(grey.rows), nan);
  for (int row = 0; row < grey.rows; ++row) {
    double sum = 0.0;
    int count = 0;
    bool all = true;
    for (const auto& [first, last] : bands_) {
      for (int column = first; column <= last; ++column) {
        all = all && seen(row, column) != 0;
        sum += grey.at<std::uint8_t>(row, column);
        ++count;
      }
    }
    if (all && count > 0) profile[static_cast<std::size_t>(row)] = sum / count;
  }
  std::vector<double> change(profile.size(), nan);
  for (std::size_t row = 2; row + 2 < profile.size(); ++row)
    change[row] = 0.25 * (profile[row + 2] + 2.0 * profile[row + 1] - 2.0 * profile[row - 1] -
                          profile[row - 2]);
  // 2. Each edge near where it is expected
  const double height = (edges_[0].drawn - edges_[1].drawn) / grid_.cell();
  // What starts at once goes some rows before the next picture: as many as is stated, or twice
  const double since = last_time_ ? time - *last_time_ : 0.0;
  const double stated = mover_.velocity.norm() * since / grid_.cell();
  last_time_ = time;
  for (Edge& edge : edges_) {
    const bool is_first = edge.record.time.empty();
    edge.record.time.push_back(time);
    edge.record.height.push_back(nan);
    if (edge.lost) continue;
    // The rig was measured to a few hundredths, and a rim shows parallax
    const double reach =
        is_first ? 0.1 * height : std::max({3.0, 0.05 * height, 2.0 * stated - edge.step});
    const double expected = is_first ? grid_.row(edge.drawn) : edge.row - edge.step;
    const int from = std::max(3, static_cast<int>(std::floor(expected - reach)));
    const int to =
        std::min(grey.rows - 4, static_cast<int>(std::ceil(expected + (is_first ? reach : 3.0))));
    double strongest = 0.0;
    int best = -1;
    for (int row = from; row <= to; ++row) {
      const double here = change[static_cast<std::size_t>(row)];
      const double value = edge.sign == 0.0 ? std::abs(here) : edge.sign * here;
      if (!(value > strongest)) continue;
      strongest = value;
      best = row;
    }
    if (best < 1 || strongest < 0.4 * edge.strength) {
      edge.lost = is_first;
      continue;
    }
    const auto b = static_cast<std::size_t>(best);
    const double curvature = change[b - 1] - 2.0 * change[b] + change[b + 1];
    const double offset =
        curvature != 0.0 && std::isfinite(curvature)
            ? std::clamp(0.5 * (change[b - 1] - change[b + 1]) / curvature, -1.0, 1.0)
            : 0.0;
    const double row = best + offset;
    if (is_first) {
      edge.sign = change[b] > 0.0 ? 1.0 : -1.0;
      edge.strength = strongest;
    } else {
      edge.step = std::max(0.0, edge.row - row);
    }
    edge.strength += 0.05 * (strongest - edge.strength);
    edge.row = row;
    ++edge.found;
    edge.record.height.back() = rises_by(edge, row);
  }
}

std::optional<Lift> LiftWatcher::lift() const {
  std::optional<Lift> best;
  for (const Edge& edge : edges_) {
    const std::optional<Lift> lift = fit_lift(edge.record, 0.0);
    if (lift && (!best || lift->speed_sigma < best->speed_sigma)) best = lift;
  }
  return best;
}

std::optional<double> LiftWatcher::longer_by(double until) const {
  std::vector<double> apart;
  for (std::size_t i = 0; i < edges_[0].record.time.size(); ++i) {
    if (edges_[0].record.time[i] > until || i >= edges_[1].record.height.size()) break;
    const double one = edges_[0].record.height[i] - edges_[1].record.height[i];
    if (std::isfinite(one)) apart.push_back(one);
  }
  if (apart.size() < 2) return std::nullopt;
  return median(apart);
}

std::vector<Eigen::Vector2d> LiftWatcher::shadow(double rise) const {
  std::vector<cv::Point2f> points;
  const auto add = [&](double x, double before, double z) {
    const double share = eye_.z() / (eye_.z() - before);
    points.emplace_back(static_cast<float>(eye_.x() + (x - eye_.x()) * share),
                        static_cast<float>(eye_.y() + (z - eye_.y()) * share));
  };
  double middle = 0.0;
  for (const Eigen::Vector2d& corner : mover_.drawing) {
    middle += corner.x() / static_cast<double>(mover_.drawing.size());
    add(corner.x(), 0.0, corner.y() + rise);
  }
  if (mover_.radius > 0.0) {
    constexpr int steps = 32;
    for (int i = 0; i < steps; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / steps;
      for (const Edge& edge : edges_)
        add(middle + mover_.radius * std::cos(angle),
            mover_.radius * std::sin(angle),
            edge.drawn + rise);
    }
  }
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull);
  std::vector<Eigen::Vector2d> outline;
  for (const cv::Point2f& point : hull) outline.push_back(turned_back({point.x, point.y}));
  return outline;
}

}  // namespace graintruth::tracking
