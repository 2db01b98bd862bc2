// The joint fit of a bed of touching plates to one frame: the picture is the sum of all plates,
//   contrast(p) = sum_k g_k S(q_k(p)),   q_k(p) = diag(1/a, 1/b) R(angle_k)^T (plane(p) - centre_k)
// with the look S learned from the film. Every plate in turn is fitted by Gauss-Newton to what the
// others leave of the picture. Sums are right for touching plates, because a lens blurs sums into
// sums.
#pragma once

#include <Eigen/Dense>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/plates/plate.h"
#include "tracking/plates/plate_look.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

struct PlateFit {
  datasets::Pose pose;
  double gain = 0.0;      // brightness of the plate, grey levels of contrast
  double ground = 0.0;    // contrast of the ground about it, grey levels
  double score = 0.0;     // share of the plate's own contrast that the model explains, at most 1
  double visible = 0.0;   // share of the plate's area inside the part of the picture that counts
  double residual = 0.0;  // grey levels, rms over the plate
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle; white residuals
};

// Where in the picture plates can be seen.
struct BedView {
  const Camera* camera = nullptr;
  PlateShape shape;
  double height = 0.0;  // m, of what is seen of a plate above the plane of the centres
  cv::Rect region;      // of the frame
  cv::Mat1b usable;     // of the region: 0 where a wall hides plates
};

// Seen from the side a plate's outline lies between its front face and its middle, depending on how
// much light the rim gets: half way, m above the plane of the centres.
inline double seen_height(double thickness) { return 0.25 * thickness; }

// By how much a plate there seems off because that height is known to no more than the quarter of
// the thickness that separates both ends of its range (uniform: over the square root of three), m.
inline Eigen::Vector2d height_error(const Camera& camera,
                                    double height,
                                    const Eigen::Vector2d& place) {
  const double slant = height / std::numbers::sqrt3 / camera.position().z();
  return slant * (place - camera.position().head<2>());
}

class BedFit {
 public:
  // `contrast` is that of the view's region. Only rows first_row, first_row + row_step, ... of the
  // region count (fields of an interlaced frame).
  BedFit(const BedView& view, const LitLook& look, cv::Mat1f contrast, int first_row, int row_step);

  // Adds a plate to the model and returns its index.
  std::size_t add(const datasets::Pose& pose, double gain);
  // Takes it out of the model; its index stays.
  void remove(std::size_t plate);
  bool is_present(std::size_t plate) const { return plates_[plate].present; }
  std::size_t size() const { return plates_.size(); }

  // One Gauss-Newton step for each plate. A step is no longer than `longest_step` (m, and radians
  // times the semi-major axis); gains stay within a factor of two of `usual_gain` where that is not
  // 0. Returns the longest step taken, m.
  double sweep(double longest_step);
  double improve(std::size_t plate, double longest_step);
  // Moves a plate without fitting.
  void move(std::size_t plate, const datasets::Pose& pose);
  // Back to what was measured before.
  void restore(std::size_t plate, const PlateFit& fit);

  const datasets::Pose& pose(std::size_t plate) const { return plates_[plate].fit.pose; }
  // The fit with its score and covariance at the present pose.
  PlateFit measure(std::size_t plate) const;
  // Squared errors of x, z and angle over what white residuals would make of them. `blocks`: sums
  // over blocks of pixels in place of single ones (Liang and Zeger 1986). `halves`: the inner and
  // the outer part of the plate asked separately, which tells of errors that a whole part shares,
  // such as holes that a codec lets lag behind a turning rim. `leverage`: of an error that each
  // part has of its own, its square in the whole over what it adds to `halves`,
  //   (w1^2 + w2^2) / (2 w1 w2),  w the parts' weights by information.
  struct Variances {
    Eigen::Vector3d blocks, halves, leverage;
  };
  Variances variances(std::size_t plate) const;
  // Brightness and score of a plate that is not in the model, were it at `pose`.
  double gain_at(const datasets::Pose& pose, double* score) const;

  // Adds what is seen of a plate to the mean look (`unlit` is the part of it without side light)
  // and to what is known of the light.
  void gather(std::size_t plate, const PlateLook& unlit, PlateLook::Gatherer& gatherer) const;
  void gather(std::size_t plate, LightGatherer& gatherer) const;
  // The look of all later steps; plates in the model are drawn anew.
  void set_look(const LitLook& look);

  // What no plate explains.
  const cv::Mat1f& residual() const { return residual_; }
  const BedView& view() const { return view_; }

 private:
  // A plate's place in the picture, and the map from pixels to its body coordinates.
  struct Placement {
    Eigen::Vector2f centre;  // px in the region
    Eigen::Matrix2f to_body;
    const PlateLook* look = nullptr;
    cv::Rect box;
    float cosine = 1.0F, sine = 0.0F;
  };
  struct Plate {
    PlateFit fit;
    bool present = false;
    Placement placement;
    std::vector<float> drawn;  // in the box of the placement
  };
  Placement place(const datasets::Pose& pose) const;
  void draw(Plate& plate, float sign);
  void redraw(Plate& plate);
  template <typename Visit>
  void visit(const Placement& placement, Visit&& visit) const;

  BedView view_;
  const LitLook* look_;
  cv::Mat1f residual_;  // contrast minus all plates in the model
  int first_row_, row_step_;
  std::vector<Plate> plates_;
};

}  // namespace graintruth::tracking
