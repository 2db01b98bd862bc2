// The body that a film of balls shows: one ball, or two glued together on an axis.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <filesystem>

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::tracking {

// Two balls on an axis; `first` lies towards -axis. The tracked point divides the line between the
// centres. A single ball is the first of two that coincide: the tracked point is its centre, and it
// shows no angle.
struct BodyShape {
  double separation = 0.0;                    // m, between the ball centres
  std::array<double, 2> radius = {0.0, 0.0};  // m
  double first_share = 0.5;  // distance from the first centre to the tracked point over separation
  std::size_t balls = 2;     // 1 or 2

  bool shows_angle() const { return balls == 2; }
};

struct BodyPose {
  double x = 0.0, z = 0.0;  // m, tracked point
  double angle = 0.0;       // rad, from the first ball to the second, counter-clockwise from +x
};

// Of a single ball both are its centre.
std::array<Eigen::Vector2d, 2> ball_centres(const BodyPose& pose, const BodyShape& shape);

// The shape of a body of balls. Throws datasets::InputError, which names `experiment`, where a film
// of such bodies cannot be tracked.
BodyShape nominal_shape(const datasets::SeenBody& body, const std::filesystem::path& experiment);

// Would two hard bodies in these poses run into each other by more than a measurement error?
bool overlap(const BodyPose& a, const BodyPose& b, const BodyShape& shape);

}  // namespace graintruth::tracking
