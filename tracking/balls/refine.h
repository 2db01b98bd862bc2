// A body of one or two balls fitted to the edges of its outline: rays across its arcs, sub-pixel
// gradient maxima, robust least squares on (x, z, angle). What could be seen of each ball is kept,
// so that sizes learned later over the whole clip can be put in without looking at the film again.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <optional>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/balls/body.h"
#include "tracking/balls/limb_model.h"
#include "tracking/view/camera.h"
#include "tracking/view/edge_image.h"

namespace graintruth::tracking {

// Discs and lines of the plane whose edges must not be taken for a body's own.
struct Surroundings {
  struct Disc {
    Eigen::Vector2d centre;
    double radius = 0.0;
  };
  std::vector<Disc> discs;            // balls of the other bodies
  std::vector<datasets::Wall> walls;  // seen edge-on

  void add(const BodyPose& body, const BodyShape& shape) {
    const auto centres = ball_centres(body, shape);
    for (std::size_t ball = 0; ball < shape.balls; ++ball)
      discs.push_back({centres[ball], shape.radius[ball]});
  }
};

// What the rays told of one ball, linear about (x, z, radius) = `reference`:
// the best estimate is reference + information^-1 * gain. Weights are per px^2 of edge
// displacement.
struct BallEvidence {
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gain = Eigen::Vector3d::Zero();
};

struct BodyFit {
  BodyPose pose;
  std::array<BallEvidence, 2> balls;
  double support =
      0.0;  // share of the rays that could be seen and met an edge where the outline says, 0..1
  double visible = 0.0;  // share of the body's outline that no neighbour or wall comes near, 0..1
  double scatter_px = 0.0;     // robust standard deviation of a ray about the fit
  double edge_strength = 0.0;  // median gradient, in units of those just inside the outline
  std::array<double, 4> autocovariance =
      {};                         // px^2, of neighbouring rays' residuals at lags 0..3, summed
  std::array<int, 4> pairs = {};  // how many pairs went into each
  Eigen::Vector3f colour =
      Eigen::Vector3f::Zero();  // mean brightness and colour differences (Y, Cr, Cb) inside
};

// A pose and its information: 1/m^2, 1/rad^2.
struct KnownPose {
  BodyPose pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

// What one ray is worth, px^2: its variance, and how many neighbours share its error. From sums of
// `autocovariance` and `pairs` over fits.
double ray_variance(const std::array<double, 4>& autocovariance,
                    const std::array<double, 4>& pairs);

struct RefineOptions {
  double window_px = 3.0;  // how far an edge may lie from where the outline is expected
  int iterations = 3;
  double noise = 2.0;  // grey levels
  // Places the edges that were found; without it they lie where the picture changes most.
  const LimbModel* limb = nullptr;
  // Above 0: looks for the limb itself, that near to the outline, instead of for strong edges.
  double limb_reach_px = 0.0;
  // What else is known of the pose, such as by the paint; without it only the outline tells.
  // Weighed against the rays by what one of them is worth, `ray_variance` in px^2.
  std::optional<KnownPose> known;
  double ray_variance = 0.0;
};

// Moves `start` to where its outline meets edges. Never fails: a low `support` tells that there is
// no such body.
BodyFit refine_body(const EdgeImage& image,
                    const Camera& camera,
                    const BodyShape& shape,
                    const BodyPose& start,
                    const Surroundings& surroundings,
                    const RefineOptions& options);

// One ray that met an edge: how far outside the outline of a pose, and how that changes with it.
struct SeenRay {
  int ball = 0, direction = 0;  // of `rays_per_ball`, counter-clockwise from +x
  double displacement = 0.0;    // px
  double variance = 0.0;        // px^2, of the limb fitted
  Eigen::Vector3d derivative =
      Eigen::Vector3d::Zero();  // of displacement by ball (x, z, radius), px/m
};
constexpr int rays_per_ball = 72;  // one in 5 degrees: about every 2 px on a ball of 48 px

// The limb of a body whose pose is known to within `reach` px: the rays that see it.
std::vector<SeenRay> measure_limb(const EdgeImage& image,
                                  const Camera& camera,
                                  const BodyShape& shape,
                                  const BodyPose& pose,
                                  const Surroundings& surroundings,
                                  const LimbModel& limb,
                                  double reach,
                                  double noise);

// The rays of a body at `pose` that meet an edge, and where it is: what a limb model is learned
// from.
struct ObservedLimbs {
  std::vector<RayProfile> profiles;
  std::vector<double> edges;  // px outwards
};
void observe_limbs(const EdgeImage& image,
                   const Camera& camera,
                   const BodyShape& shape,
                   const BodyPose& pose,
                   const Surroundings& surroundings,
                   const RefineOptions& options,
                   ObservedLimbs& observed);

}  // namespace graintruth::tracking
