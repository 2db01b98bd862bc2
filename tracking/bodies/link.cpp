#include "tracking/bodies/link.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "tracking/bodies/assignment.h"

namespace graintruth::tracking {

double axis_difference(double a, double b) {
  const double half_turns = std::round((a - b) / std::numbers::pi);
  return a - b - half_turns * std::numbers::pi;
}

Mismatch mismatch(const Expectation& expected, const Detection& detection) {
  constexpr double colour_sigma =
      12.0;  // grey levels: light and shade change the same ball by that much
  const BodyPose& pose = detection.pose;
  return {(std::pow(pose.x - expected.pose.x, 2) + std::pow(pose.z - expected.pose.z, 2)) /
              std::pow(expected.position_sigma, 2),
          std::pow(axis_difference(pose.angle, expected.pose.angle) / expected.angle_sigma, 2),
          (detection.colour - expected.colour).squaredNorm() / (3.0 * colour_sigma * colour_sigma)};
}

std::vector<int> link(const std::vector<Expectation>& expectations,
                      const std::vector<Detection>& detections) {
  constexpr double gate = 5.0;  // standard deviations
  constexpr double forbidden = 1.0e9;
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(expectations.size()),
                       static_cast<Eigen::Index>(detections.size()));
  for (std::size_t i = 0; i < expectations.size(); ++i) {
    for (std::size_t j = 0; j < detections.size(); ++j) {
      const Mismatch off = mismatch(expectations[i], detections[j]);
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          off.position > gate * gate ? forbidden : off.sum();
    }
  }
  return assign(cost, forbidden);
}

std::vector<int> number_by_start(const std::vector<Eigen::Vector2d>& detections,
                                 const std::vector<datasets::StartPlace>& starts,
                                 int count,
                                 double row_height) {
  if (!starts.empty()) {
    Eigen::MatrixXd cost(static_cast<Eigen::Index>(starts.size()),
                         static_cast<Eigen::Index>(detections.size()));
    for (std::size_t i = 0; i < starts.size(); ++i)
      for (std::size_t j = 0; j < detections.size(); ++j)
        cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            std::pow(starts[i].x - detections[j].x(), 2) +
            std::pow(starts[i].z - detections[j].y(), 2);
    std::vector<int> result = assign(cost);
    result.resize(static_cast<std::size_t>(count), -1);
    return result;
  }
  std::vector<int> order(detections.size());
  std::iota(order.begin(), order.end(), 0);
  const auto x = [&](int i) { return detections[static_cast<std::size_t>(i)].x(); };
  const auto z = [&](int i) { return detections[static_cast<std::size_t>(i)].y(); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return z(a) < z(b); });
  // A row: all that lie within a row's height of its lowest member.
  for (std::size_t from = 0; from < order.size();) {
    std::size_t to = from;
    while (to < order.size() && z(order[to]) - z(order[from]) < row_height) ++to;
    std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(from),
                     order.begin() + static_cast<std::ptrdiff_t>(to),
                     [&](int a, int b) { return x(a) < x(b); });
    from = to;
  }
  order.resize(static_cast<std::size_t>(count), -1);
  return order;
}

}  // namespace graintruth::tracking
