#include "tracking/plates/plate.h"

#include <Eigen/Dense>
#include <cmath>

namespace graintruth::tracking {

PlateShape plate_shape(const datasets::SeenBody& body) {
  return {body.lengths.at("semi_major"), body.lengths.at("semi_minor")};
}

// With A = R diag(a^2, b^2) R^T of each plate and r between the centres,
//   scale^2 = max over l in (0, 1) of  l (1 - l) r^T [(1 - l) A_1 + l A_2]^-1 r,
// a concave function of l.
double touching_scale(const datasets::Pose& one,
                      const datasets::Pose& other,
                      const PlateShape& shape) {
  const auto matrix = [&](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    const double a2 = shape.semi_major * shape.semi_major, b2 = shape.semi_minor * shape.semi_minor;
    Eigen::Matrix2d result;
    result << a2 * c * c + b2 * s * s, (a2 - b2) * c * s, (a2 - b2) * c * s,
        a2 * s * s + b2 * c * c;
    return result;
  };
  const Eigen::Matrix2d first = matrix(one.angle), second = matrix(other.angle);
  const Eigen::Vector2d r(other.x - one.x, other.z - one.z);
  const auto square = [&](double l) {
    const Eigen::Matrix2d mixed = (1.0 - l) * first + l * second;
    return l * (1.0 - l) * r.dot(mixed.inverse() * r);
  };
  double low = 0.0, high = 1.0;
  constexpr int halvings = 16;  // the maximum is flat: a part in a million of the scale
  for (int i = 0; i < halvings; ++i) {
    const double left = low + 0.382 * (high - low), right = high - 0.382 * (high - low);
    (square(left) < square(right) ? low : high) = square(left) < square(right) ? left : right;
  }
  return std::sqrt(square(0.5 * (low + high)));
}

}  // namespace graintruth::tracking
