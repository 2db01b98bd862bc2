// Where a ball ends along a ray: not where the picture changes most, which shading draws inwards on
// the lit side, but where a blurred limb fits best.
//   colour(t) = ground (1 - Phi((edge - t) / blur)) + paint (light Phi + shading H(t - edge))
// Phi is the blurred step, H the blurred limb: light on a ball falls towards its outline like the
// height of its surface above the plane of the outline, h^2 = 2 R s - s^2 at the depth s inside.
// Paint is the ball's own colour, seen deeper inside on the same ray: light and shade change how
// bright it is but not its hue, so that a limb is seen by its hue where ball and ground are equally
// bright, and a shadow on the ball is no limb. `ground`, `light` and `shading` are free on each
// ray.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace graintruth::tracking {

// Colours along a ray from the inside outwards, `step` apart.
struct RayProfile {
  static constexpr int inside = 12, outside = 8;  // samples on either side of the expected outline
  static constexpr int samples = inside + 1 + outside;
  static constexpr double step = 0.5;  // px
  std::array<Eigen::Vector3f, samples> colours;
  int usable = samples;  // from the inside; what follows belongs to a neighbour
};

struct LimbEdge {
  bool found = false;
  double position = 0.0;  // px outwards of the expected outline
  double variance = 0.0;  // px^2, of the position, from how fast the misfit rises
};

class LimbModel {
 public:
  // For balls of `radius_px` under a Gaussian blur of brightness and of colour, px. `black` is how
  // bright the film shows what sends no light, grey levels. Computes its tables; to be kept.
  LimbModel(double radius_px, double brightness_blur_px, double colour_blur_px, double black = 0.0);

  double brightness_blur_px() const { return blur_px_[0]; }
  double colour_blur_px() const { return blur_px_[1]; }
  double black() const { return black_; }

  // The best edge within `reach` px of `start`. Not found where the misfit has no minimum there.
  LimbEdge locate(const RayProfile& profile, double start, double reach, double noise) const;

  // Sums of squared misfits of brightness and of both colour differences at their own best edges,
  // each with a shading of its own.
  std::array<double, 2> misfits(const RayProfile& profile, double start, double reach) const;

 private:
  static constexpr int least_usable = RayProfile::inside + 3;
  static constexpr int positions_per_px = 4;
  static constexpr int most_px = 3;
  static constexpr int positions = 2 * most_px * positions_per_px + 1;

  // At one position of the edge: the ground, of unit length; light and shading, less what the
  // ground explains of them; 0 beyond what is usable.
  struct Basis {
    Eigen::Matrix<float, 3, RayProfile::samples> rows;
    Eigen::Matrix2d products;  // of light and shading
  };
  struct Range {
    int first = 0, last = 0;  // positions
  };
  struct Samples {
    Eigen::Matrix<float, RayProfile::samples, 3> colours;  // above black; 0 beyond usable
    std::array<double, 3> square = {};                     // of each channel, summed
    Eigen::Vector3d paint = Eigen::Vector3d::Zero();
    int usable = 0;
  };
  struct Misfit {
    std::array<double, 2> parts = {};  // squared, of brightness and of both colour differences
    double total = 0.0;                // weighted
  };

  static std::size_t index_of(int part, int usable, int position);
  static Range range(double start, double reach);
  Samples samples_of(const RayProfile& profile) const;
  Misfit misfit(const Samples& samples, int position, const std::array<double, 2>& weights) const;

  std::array<double, 2> blur_px_;
  float black_ = 0.0F;
  std::vector<Basis> bases_;
};

// How bright a film shows what sends no light, grey levels: 0 but for haze, and far off it for a
// negative. Light changes the brightness of a body's paint but not its hue, so that the colours of
// every body lie on a line through it. `firsts` says where the profiles of each body begin, and
// ends with their number. 0 where the film does not clearly say otherwise.
double learn_black(const std::vector<RayProfile>& profiles, const std::vector<std::size_t>& firsts);

// The blurs that fit a film best, from rays that met an edge near `starts`.
LimbModel learn_limb_model(double radius_px,
                           const std::vector<RayProfile>& profiles,
                           const std::vector<double>& starts,
                           double black = 0.0);

}  // namespace graintruth::tracking
