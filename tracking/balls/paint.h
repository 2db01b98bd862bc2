// What a pair of balls shows inside its outline, followed from frame to frame: numerals, stripes
// and shading move with the body whatever lies behind it, so a body whose outline has the shade of
// the ground is not lost.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "tracking/balls/body.h"
#include "tracking/view/camera.h"
#include "tracking/view/edge_image.h"
#include "tracking/view/texture.h"

namespace graintruth::tracking {

// One body as it looked of late, on the grids of both balls.
struct Paint {
  std::array<std::vector<Eigen::Vector3f>, 2> looks;  // Y, Cr, Cb of every sample
  int frames = 0;                                     // that were learned

  bool is_known() const { return frames > 0; }
  // Adds one frame, with the weight of one among those learned but at least this: then older ones
  // fade. Nothing happens where a patch is empty.
  void learn(const std::array<TexturePatch, 2>& patches, float least_weight);
};

// Where the paint says that the body lies.
struct PaintFit {
  bool found = false;
  BodyPose pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of x, z, angle; 1/m^2, 1/rad^2
  // How alike what the balls show is to what they used to show, beyond even light and its slopes:
  // a coefficient of correlation, 1 for the same picture, about 0 for another's.
  double likeness = 0.0;
};

// Least squares on (x, z, angle) from `start`, which must lie within the width of what is painted.
// Light that grows or falls evenly over a ball is no motion; highlights and edges of shadows count
// less.
PaintFit fit_paint(const EdgeImage& image,
                   const Camera& camera,
                   const BodyShape& shape,
                   const BodyPose& start,
                   const std::array<TextureGrid, 2>& grids,
                   const Paint& paint);

// Along and across the body's axis, m, and its turn, rad, from where one frame's patches were
// sampled to where the paint lies there; against the mean of all frames.
struct PaintShift {
  bool found = false;
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // in the axes of the body
  double likeness = 0.0;
  // m: what the distance of the two balls seems to be more than in the mean. Balls are rigid: it is
  // what their paint errs.
  double stretch = 0.0;
};
std::vector<PaintShift> compare_paint(const std::vector<std::array<TexturePatch, 2>>& frames,
                                      const BodyShape& shape,
                                      const std::array<TextureGrid, 2>& grids);

// A pose moved by a change in the axes of the body.
BodyPose moved(const BodyPose& pose, const Eigen::Vector3d& change);

// An information in the axes of a body that lies at this angle, turned into those of the
// laboratory.
Eigen::Matrix3d in_laboratory(const Eigen::Matrix3d& information, double angle);

}  // namespace graintruth::tracking
