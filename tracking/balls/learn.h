// What the whole clip tells of each body's true size, and every pose solved again with it.
#pragma once

#include <vector>

#include "tracking/balls/refine.h"

namespace graintruth::tracking {

struct LearnedShape {
  BodyShape shape;
  double ray_variance_px2 = 0.0;  // of one ray, correlation with its neighbours included
  // Scatter of the separation (of a single ball: of its radius) from frame to frame over what the
  // rays' own errors make of it: the clip's own check of those errors. More than 1 where light,
  // shade and compression do what single rays do not know; less where errors of neighbouring rays
  // are shared by both balls or lie across the axis.
  double excess = 1.0;
  // m, rms: by how much ball 2 may be larger than ball 1 beyond what is stated. Paint cancels in
  // it.
  double radius_difference = 0.0;
};

struct Learned {
  std::vector<LearnedShape> bodies;
  double radius_mean = 0.0, radius_spread = 0.0;          // m, over balls
  double separation_mean = 0.0, separation_spread = 0.0;  // m, over bodies; 0 for single balls
};

// `fits[body]` holds every frame in which the body was seen.
Learned learn_shapes(const std::vector<std::vector<BodyFit>>& fits, const BodyShape& nominal);

struct SolvedPose {
  BodyPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle; rays only
};

// The rigid pose of known sizes that agrees best with what was seen of its balls. The angle of a
// single ball stays as it was and has no meaning, nor has its variance.
SolvedPose solve_pose(const BodyFit& fit, const LearnedShape& learned);

}  // namespace graintruth::tracking
