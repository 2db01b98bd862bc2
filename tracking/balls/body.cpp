#include "tracking/balls/body.h"

#include <fmt/format.h>

#include <cmath>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

using datasets::InputError;

std::array<Eigen::Vector2d, 2> ball_centres(const BodyPose& pose, const BodyShape& shape) {
  const Eigen::Vector2d point(pose.x, pose.z), axis(std::cos(pose.angle), std::sin(pose.angle));
  return {point - shape.first_share * shape.separation * axis,
          point + (1.0 - shape.first_share) * shape.separation * axis};
}

BodyShape nominal_shape(const datasets::SeenBody& body, const std::filesystem::path& experiment) {
  const auto& spheres = body.balls;
  if (spheres.empty() || spheres.size() > 2) {
    throw InputError(fmt::format(
        "{}: particle: films can be tracked for particles of one ball or two, this one has {}; "
        "track them with another program and give its files as tracks (docs/imports.md)",
        experiment.string(),
        spheres.size()));
  }
  if (body.count.value_or(0) < 1) {
    throw InputError(fmt::format("{}: particle.count must say how many particles the film shows",
                                 experiment.string()));
  }
  BodyShape shape;
  if (spheres.size() == 1) {
    if (!(spheres[0].radius > 0.0) || spheres[0].offset != 0.0) {
      throw InputError(
          fmt::format("{}: particle: a single ball must have a positive radius and its centre of "
                      "mass in its middle, offset 0",
                      experiment.string()));
    }
    shape.balls = 1;
    shape.radius = {spheres[0].radius, spheres[0].radius};
    return shape;
  }
  const bool ordered = spheres[0].offset <= spheres[1].offset;
  const datasets::AxialSphere& first = ordered ? spheres[0] : spheres[1];
  const datasets::AxialSphere& second = ordered ? spheres[1] : spheres[0];
  shape.separation = second.offset - first.offset;
  shape.radius = {first.radius, second.radius};
  if (!(shape.separation > 0.0) || !(first.radius > 0.0) || !(second.radius > 0.0)) {
    throw InputError(fmt::format(
        "{}: particle: the two balls must have positive radii and different places on the axis",
        experiment.string()));
  }
  shape.first_share = -first.offset / shape.separation;
  return shape;
}

bool overlap(const BodyPose& a, const BodyPose& b, const BodyShape& shape) {
  constexpr double tolerated = 0.85;  // of the contact distance
  for (const Eigen::Vector2d& p : ball_centres(a, shape)) {
    for (const Eigen::Vector2d& q : ball_centres(b, shape)) {
      if ((p - q).norm() < tolerated * (shape.radius[0] + shape.radius[1])) return true;
    }
  }
  return false;
}

}  // namespace graintruth::tracking
