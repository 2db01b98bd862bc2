// What the whole clip tells of each body's true size, and every pose solved again with it.
#pragma once

#include <vector>

#include "tracking/refine.h"

namespace graintruth::tracking {

struct LearnedShape {
  BodyShape shape;
  double ray_variance_px2 = 0.0;  // of one ray, correlation with its neighbours included
};

struct Learned {
  std::vector<LearnedShape> bodies;
  double radius_mean = 0.0, radius_spread = 0.0;          // m, over balls
  double separation_mean = 0.0, separation_spread = 0.0;  // m, over bodies
  // By how much the sizes seen from frame to frame scatter more than the rays' own errors explain (>= 1): what the
  // rays do not know of light, shade and compression.
  double excess = 1.0;
};

// `fits[body]` holds every frame in which the body was seen.
Learned learn_shapes(const std::vector<std::vector<BodyFit>>& fits, const BodyShape& nominal);

struct SolvedPose {
  BodyPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle; rays only
};

// The rigid pose of known sizes that agrees best with what was seen of both balls.
SolvedPose solve_pose(const BodyFit& fit, const LearnedShape& learned, double excess);

}  // namespace graintruth::tracking
