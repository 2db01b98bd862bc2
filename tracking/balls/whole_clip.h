// Pairs of balls through the whole clip. What is painted on a body tells how it moved, from frame
// to frame and to a twentieth of a pixel, but not where in the paint the balls' centres lie. The
// limb tells that: it is the same for all frames, so that what single rays get wrong - faint edges,
// shadows, neighbours - can be told apart from it and counted. Pictures kept from all over the clip
// are looked at again once it is known where every body lies.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/balls/body_follower.h"
#include "tracking/balls/learn.h"

namespace graintruth::tracking {

// The pose of one body in one frame, from all witnesses.
struct ClipPose {
  bool found = false;
  BodyPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle
};

// What the film itself says of the errors of one body.
struct BodyCheck {
  // px, rms over the sides of its outline: what the fit left, and what it usually leaves in this
  // film where the limb is as faint. A shadow or a neighbour that is taken for a limb makes sides
  // disagree.
  double outline_left = 0.0, outline_usual = 0.0;
  int sides = 0;              // that were seen, of 24
  double paint_wander = 0.0;  // px: what the paint of one ball errs, from a distance that is rigid
};

struct Clip {
  std::vector<BodyCheck> checks;             // one a body
  Learned learned;                           // sizes
  std::vector<std::vector<ClipPose>> poses;  // one list a body, one entry a frame
};

// `tracks` hold one entry a frame; their textures lie on `grids`. Poses are not found in frames
// whose paint was not seen.
Clip solve_clip(const FilmView& view,
                const std::vector<BodyTrack>& tracks,
                const std::array<TextureGrid, 2>& grids,
                const std::vector<KeptPicture>& pictures);

}  // namespace graintruth::tracking
