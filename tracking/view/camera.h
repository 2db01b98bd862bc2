// From laboratory coordinates to pixels: a pinhole with radial distortion, calibrated on whatever
// has a known place. Lab points are (x, z, h): x right, z up, h towards the camera from the plane
// of the particle centres, in metres. Pixels are (column, row), integers at pixel centres, row
// downwards.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

namespace graintruth::tracking {

// Pinhole and lens. With (X, Y, Z) the point in the camera's frame (right, down, forward) and u =
// X/Z, v = Y/Z,
//   column = c_x + f / a * u (1 + k1 r^2 + k2 r^4),   row = c_y + f * v (1 + k1 r^2 + k2 r^4), r^2
//   = u^2 + v^2
// (Brown 1966), the principal point c at the middle of the picture where no lens says otherwise,
// and a the pixel aspect (width over height).
class Camera {
 public:
  // log f, log a, rotation vector (3), foot of the optical axis in the plane (2, m), log distance,
  // k1, k2
  using Parameters = Eigen::Matrix<double, 10, 1>;

  Camera() = default;
  Camera(int width, int height, const Parameters& parameters);
  Camera(int width,
         int height,
         const Parameters& parameters,
         const Eigen::Vector2d& principal_point);

  Eigen::Vector2d project(const Eigen::Vector3d& point) const;
  Eigen::Vector2d project(double x, double z) const { return project(Eigen::Vector3d(x, z, 0.0)); }
  // The point (x, z) of the particle plane that is seen at a pixel.
  Eigen::Vector2d unproject(const Eigen::Vector2d& pixel) const;
  // d(column, row) / d(x, z) in the particle plane, px/m.
  Eigen::Matrix2d jacobian(double x, double z) const;
  // Pixels a metre there: square root of the area scale.
  double scale(double x, double z) const;
  // Where the camera stands, lab coordinates.
  const Eigen::Vector3d& position() const { return position_; }

  const Parameters& parameters() const { return parameters_; }
  double focal_length_px() const { return focal_; }
  double pixel_aspect() const { return aspect_; }
  double distance() const { return translation_.z(); }  // m, along the optical axis
  double k1() const { return parameters_[8]; }
  double k2() const { return parameters_[9]; }
  const Eigen::Vector2d& principal_point() const { return principal_point_; }  // px
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_ = 0, height_ = 0;
  Parameters parameters_ = Parameters::Zero();
  Eigen::Vector2d principal_point_ = Eigen::Vector2d::Zero();
  double focal_ = 1.0, aspect_ = 1.0;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
};

// The visible outline of a sphere whose centre lies in the particle plane: `count` pixels at equal
// steps of the angle from +x, counter-clockwise. A pinhole sees the circle in which the cone from
// the eye touches the sphere,
//   centre S - v R^2 / L^2,  radius R sqrt(1 - R^2 / L^2),  in the plane across v = S - V,  L =
//   |v|,
// so neither the shift nor the ellipticity of the outline biases a fit that uses it.
void sphere_outline(
    const Camera& camera, double x, double z, double radius, std::vector<Eigen::Vector2d>& outline);

// Where a disc lying in the particle plane has its centre of area in the picture.
Eigen::Vector2d disc_centroid(const Camera& camera, double x, double z, double diameter);

// A point, or the middle of a disc, of known place that was seen in the picture.
struct CameraReference {
  int number = -1;                                  // in the list that the laboratory gave
  double x = 0.0, z = 0.0;                          // m
  double diameter = 0.0;                            // m; 0 of a point
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // of a disc its centre of area
};

struct Calibration {
  Camera camera;
  Eigen::Matrix<double, 10, 10> covariance;  // of the camera's parameters
  std::vector<int> used;                     // numbers of references
  std::vector<double> residuals;             // m in the plane, one a used reference
  // m; NaN where nothing can disagree
  double rms = 0.0, max = 0.0, leave_one_out_rms = 0.0, leave_one_out_max = 0.0;
  double pixel_sigma = 0.0;  // px per axis, scatter of the references about the camera model

  // Covariance of a plane point that comes from the calibration alone, m^2.
  Eigen::Matrix2d point_covariance(double x, double z) const;
};

// A lens that was calibrated by itself. Standard deviations beside the values.
struct KnownLens {
  double focal_px = 0.0, focal_sigma_px = 0.0;
  double k1 = 0.0, k1_sigma = 0.0, k2 = 0.0, k2_sigma = 0.0;
  Eigen::Vector2d principal_point = Eigen::Vector2d::Zero();  // px
};

struct CalibrationOptions {
  int width = 0, height = 0;  // px
  double pixel_aspect = 1.0;
  double expected_sigma_px = 0.05;  // of a reference, per axis; priors count as if it were this
  double least_sigma_px = 0.01;     // no scatter makes them better than this
  std::optional<KnownLens> lens;
};

inline constexpr std::size_t fewest_references = 4;  // that fix a camera

// Levenberg-Marquardt on all ten parameters with wide priors, so that four references suffice and
// more take over. Those far off the rest are left out. Throws InputError when fewer than four
// remain.
Calibration calibrate(const std::vector<CameraReference>& references,
                      const CalibrationOptions& options);

// A length that was seen, with its relative standard deviation, and where the origin is seen.
struct KnownLength {
  Eigen::Vector2d from, to;  // px
  double length = 0.0;       // m
  double relative_sigma = 0.0;
  Eigen::Vector2d origin;  // px
};
// The camera that sees it, taken as level and square to the plane.
Calibration level_camera(const KnownLength& known, const CalibrationOptions& options);

// The distance in the plane of two points that were clicked, and its standard deviation by the
// clicks (px, per axis) and the calibration.
struct MeasuredLength {
  double length = 0.0, sigma = 0.0;  // m
};
MeasuredLength measure_length(const Calibration& calibration,
                              const Eigen::Vector2d& from,
                              const Eigen::Vector2d& to,
                              double click_error);

}  // namespace graintruth::tracking
