// Where a ball ends along a ray: not where the picture changes most, which shading draws inwards on
// the lit side, but where a blurred limb fits best.
//   colour(t) = background + step Phi((edge - t) / blur) + shading H(t - edge)
// Phi is the blurred step, H the blurred limb: light on a ball falls towards its outline like the
// height of its surface above the plane of the outline, h^2 = 2 R s - s^2 at the depth s inside.
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
  // For balls of `radius_px` under a Gaussian blur of brightness and of colour, px. Computes its
  // tables; to be kept.
  LimbModel(double radius_px, double brightness_blur_px, double colour_blur_px);

  double brightness_blur_px() const { return blur_px_[0]; }
  double colour_blur_px() const { return blur_px_[1]; }

  // The best edge within `reach` px of `start`. Not found where the misfit has no minimum there.
  LimbEdge locate(const RayProfile& profile, double start, double reach, double noise) const;

  // Sums of squared misfits of brightness and of both colour differences at their own best edges.
  std::array<double, 2> misfits(const RayProfile& profile, double start, double reach) const;

 private:
  static constexpr int least_usable = RayProfile::inside + 3;
  static constexpr int positions_per_px = 4;
  static constexpr int most_px = 3;
  static constexpr int positions = 2 * most_px * positions_per_px + 1;
  using Basis = Eigen::Matrix<float, 3, RayProfile::samples>;  // orthonormal rows, 0 beyond usable

  // Squared misfits of each part with the edge at each position from first to last.
  struct Scan {
    int first = 0, last = 0;
    std::array<std::array<double, positions>, 2> misfit;
  };

  static std::size_t index_of(int part, int usable, int position);
  Scan scan(const RayProfile& profile, double start, double reach) const;

  std::array<double, 2> blur_px_;
  std::vector<Basis> bases_;
};

// The blurs that fit a film best, from rays that met an edge near `starts`.
LimbModel learn_limb_model(double radius_px,
                           const std::vector<RayProfile>& profiles,
                           const std::vector<double>& starts);

}  // namespace graintruth::tracking
