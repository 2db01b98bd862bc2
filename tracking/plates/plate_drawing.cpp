#include "tracking/plates/plate_drawing.h"

#include <cmath>
#include <numbers>

#include "tracking/drawing/drawing.h"

namespace graintruth::tracking {

namespace {

// What the camera sees of a plate's rim, px; of one whose angle is not known its nominal lie.
std::vector<Eigen::Vector2d> plate_outline(const Camera& camera,
                                           const datasets::Pose& pose,
                                           const PlateShape& shape) {
  constexpr int points = 40;
  const double angle = std::isfinite(pose.angle) ? pose.angle : 0.0;
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<Eigen::Vector2d> outline;
  for (int k = 0; k < points; ++k) {
    const double around = 2.0 * std::numbers::pi * k / points;
    const double u = shape.semi_major * std::cos(around), v = shape.semi_minor * std::sin(around);
    outline.push_back(camera.project(pose.x + c * u - s * v, pose.z + s * u + c * v));
  }
  return outline;
}

}  // namespace

void draw_plate(cv::Mat& picture,
                const Camera& camera,
                const DrawnBody& body,
                const PlateShape& shape) {
  const datasets::Pose& pose = body.pose;
  draw_outline(picture, plate_outline(camera, pose, shape), body);
  if (body.filled || !std::isfinite(pose.angle)) return;
  const Eigen::Vector2d half =
      0.5 * shape.semi_major * Eigen::Vector2d(std::cos(pose.angle), std::sin(pose.angle));
  draw_axis(picture,
            camera.project(pose.x - half.x(), pose.z - half.y()),
            camera.project(pose.x + half.x(), pose.z + half.y()),
            body);
}

}  // namespace graintruth::tracking
