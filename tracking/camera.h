// From laboratory coordinates to pixels: a pinhole with radial distortion, calibrated on dots of
// known position. Lab points are (x, z, h): x right, z up, h towards the camera from the plane of
// the particle centres, in metres. Pixels are (column, row), integers at pixel centres, row
// downwards.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "datasets/experiment/camera.h"

namespace graintruth::tracking {

// Pinhole and lens. With (X, Y, Z) the point in the camera's frame (right, down, forward) and u =
// X/Z, v = Y/Z,
//   column = c_x + f / a * u (1 + k1 r^2 + k2 r^4),   row = c_y + f * v (1 + k1 r^2 + k2 r^4), r^2
//   = u^2 + v^2
// (Brown 1966), the principal point c at the middle of the picture and a the pixel aspect (width
// over height).
class Camera {
 public:
  // log f, log a, rotation vector (3), foot of the optical axis in the plane (2, m), log distance,
  // k1, k2
  using Parameters = Eigen::Matrix<double, 10, 1>;

  Camera() = default;
  Camera(int width, int height, const Parameters& parameters);

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
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_ = 0, height_ = 0;
  Parameters parameters_ = Parameters::Zero();
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

// A dot that was found in the picture.
struct FiducialSighting {
  int fiducial = -1;      // index into Camera.fiducials of the experiment
  Eigen::Vector2d pixel;  // centre of area
  double diameter_px = 0.0;
};

struct Calibration {
  Camera camera;
  Eigen::Matrix<double, 10, 10> covariance;  // of the camera's parameters
  std::vector<int> used;                     // fiducials
  std::vector<double> residuals;             // m in the plane, one a used fiducial
  double rms = 0.0, max = 0.0, leave_one_out_rms = 0.0, leave_one_out_max = 0.0;  // m
  double pixel_sigma = 0.0;  // px per axis, scatter of the dots about the camera model

  // Covariance of a plane point that comes from the calibration alone, m^2.
  Eigen::Matrix2d point_covariance(double x, double z) const;
};

// Levenberg-Marquardt on all ten parameters with wide priors, so that four dots suffice and more
// dots take over. Sightings far off the rest are left out. Throws InputError when fewer than four
// remain.
Calibration calibrate(const std::vector<datasets::Fiducial>& fiducials,
                      const std::vector<FiducialSighting>& sightings,
                      int width,
                      int height,
                      double pixel_aspect);

}  // namespace graintruth::tracking
