#include "datasets/store/silhouette.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace graintruth::datasets {

namespace {

constexpr long samples_a_column = 32;
constexpr double nowhere = -std::numeric_limits<double>::infinity();

// The part of the x axis that a ball's shadow covers.
struct Reach {
  double from = 0.0, to = 0.0;  // m
};

// The shadow of one ball on the plane y = 0.
class Shadow {
 public:
  Shadow(const Ball& ball, const Eye& eye)
      : ball_(ball),
        eye_(eye),
        from_eye_(ball.centre - Eigen::Vector3d(eye.x, -eye.distance, eye.z)) {}

  bool is_parallel() const { return std::isinf(eye_.distance); }
  bool is_seen() const { return is_parallel() || from_eye_.y() > ball_.radius; }

  // Seen from above the two tangents from the eye enclose it:
  //   a = atan2(x, y) -+ asin(r / hypot(x, y)),  X = x_eye + D tan a
  Reach reach() const {
    const double r = ball_.radius;
    if (is_parallel()) return {ball_.centre.x() - r, ball_.centre.x() + r};
    const double middle = std::atan2(from_eye_.x(), from_eye_.y());
    const double half = std::asin(r / std::hypot(from_eye_.x(), from_eye_.y()));
    return {eye_.x + eye_.distance * std::tan(middle - half),
            eye_.x + eye_.distance * std::tan(middle + half)};
  }

  // Its upper edge at one x, m; -infinity beside it. The upright plane through the eye and that x
  // cuts the ball in a circle of radius rho, whose middle lies s ahead of the eye and h above it.
  // The upper tangent rises by tan(atan(h/s) + asin(rho/sqrt(s^2 + h^2))).
  double top_at(double x) const {
    const double r = ball_.radius;
    if (is_parallel()) {
      const double aside = x - ball_.centre.x();
      const double square = r * r - aside * aside;
      return square < 0.0 ? nowhere : ball_.centre.z() + std::sqrt(square);
    }
    const double across = x - eye_.x;
    const double length = std::hypot(across, eye_.distance);  // m, from the eye to the plane
    const double ahead = (from_eye_.x() * across + from_eye_.y() * eye_.distance) / length;
    const double aside = (from_eye_.x() * eye_.distance - from_eye_.y() * across) / length;
    const double square = r * r - aside * aside;
    if (square < 0.0) return nowhere;
    const double height = from_eye_.z();
    const double tangent = std::sqrt(ahead * ahead + height * height - square);
    const double rho = std::sqrt(square);
    return eye_.z + length * (height * tangent + ahead * rho) / (ahead * tangent - height * rho);
  }

 private:
  const Ball& ball_;
  const Eye& eye_;
  Eigen::Vector3d from_eye_;  // m
};

}  // namespace

std::vector<double> silhouette(std::span<const Ball> balls,
                               std::span<const double> columns,
                               const Eye& eye) {
  assert(columns.size() > 1);
  const double width = columns[1] - columns[0];
  const double step = width / static_cast<double>(samples_a_column);
  const double first = columns[0] - 0.5 * width + 0.5 * step;  // m, of the first sample
  const auto count = static_cast<long>(columns.size()) * samples_a_column;
  // 1. The highest shadow at every sample
  std::vector<double> top(static_cast<std::size_t>(count), nowhere);
  for (const Ball& ball : balls) {
    const Shadow shadow(ball, eye);
    if (!shadow.is_seen()) continue;
    const Reach reach = shadow.reach();
    const double from =
        std::clamp(std::ceil((reach.from - first) / step), 0.0, static_cast<double>(count));
    const double to =
        std::clamp(std::floor((reach.to - first) / step), -1.0, static_cast<double>(count - 1));
    for (long i = static_cast<long>(from); i <= static_cast<long>(to); ++i) {
      double& highest = top[static_cast<std::size_t>(i)];
      highest = std::max(highest, shadow.top_at(first + static_cast<double>(i) * step));
    }
  }
  // 2. The mean over what is covered of each column
  std::vector<double> heights(columns.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t column = 0; column < columns.size(); ++column) {
    double sum = 0.0;
    long seen = 0;
    for (long i = 0; i < samples_a_column; ++i) {
      const double z =
          top[column * static_cast<std::size_t>(samples_a_column) + static_cast<std::size_t>(i)];
      if (z == nowhere) continue;
      sum += z;
      ++seen;
    }
    if (static_cast<double>(seen) >= least_seen_share * static_cast<double>(samples_a_column))
      heights[column] = sum / static_cast<double>(seen);
  }
  return heights;
}

}  // namespace graintruth::datasets
