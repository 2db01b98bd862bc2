// Who is who: detections of a frame given to the tracks that wait for them.
#pragma once

#include <vector>

#include "tracking/balls/body.h"

namespace graintruth::tracking {

// Where a track expects its body, and how well it knows.
struct Expectation {
  BodyPose pose;
  double position_sigma = 0.0;  // m per axis
  double angle_sigma = 0.0;     // rad
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
};

// What was found in a frame.
struct Detection {
  BodyPose pose;
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
};

// a - b brought into [-pi/2, pi/2): the difference of two directions of a body with equal ends.
double axis_difference(double a, double b);

// Squared distances over their variances: of (x, z), of the angle modulo pi, and of colour.
struct Mismatch {
  double position = 0.0, turn = 0.0, colour = 0.0;
  double sum() const { return position + turn + colour; }
};
Mismatch mismatch(const Expectation& expected, const Detection& detection);

// Global assignment by the sum of these, of pairs whose positions agree. Returns the detection of
// each expectation, -1 where none is near enough.
std::vector<int> link(const std::vector<Expectation>& expectations,
                      const std::vector<Detection>& detections);

// The numbering of the bodies in the first frame: detection of each start place by least total
// squared distance, or, without start places, by rows from the lowest, left to right. Where fewer
// bodies than places were seen, -1. `detections` are centres (x, z), m.
std::vector<int> number_by_start(const std::vector<Eigen::Vector2d>& detections,
                                 const std::vector<datasets::StartPlace>& starts,
                                 int count,
                                 double row_height);

}  // namespace graintruth::tracking
