#include "tracking/view/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

namespace {

using Parameters = Camera::Parameters;
constexpr int parameter_count = 10;

Eigen::Matrix3d rotation_matrix(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1.0e-14) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

// What is known of any laboratory camera before a dot is seen; each wide enough for the dots to
// take over.
struct Prior {
  Parameters mean, sigma;
};

Prior camera_prior(const CalibrationOptions& options) {
  const int width = options.width, height = options.height;
  const double size = std::max(width, height);
  // Camcorders stand one to six picture widths away; a single plane tells little about it.
  const double focal = 3.0 * size;
  const double corner = 0.5 * std::hypot(width, height) / focal;
  Prior prior;
  prior.mean << std::log(focal), std::log(options.pixel_aspect), 0, 0, 0, 0, 0, 0, 0, 0;
  constexpr double unknown = 1.0e3;
  // Tilts of a camera that was set up to look straight at the rig: a few degrees. Roll: free.
  prior.sigma << 0.5, 0.1, 0.15, 0.15, unknown, unknown, unknown, unknown,
      0.1 / (corner * corner),     // 10 % of the radius at the corner is a strong distortion
      0.01 / std::pow(corner, 4);  // the next term is usually a tenth of it
  if (const auto& lens = options.lens) {
    prior.mean[0] = std::log(lens->focal_px);
    prior.sigma[0] = lens->focal_sigma_px / lens->focal_px;
    prior.mean.tail<2>() << lens->k1, lens->k2;
    prior.sigma.tail<2>() << lens->k1_sigma, lens->k2_sigma;
  }
  return prior;
}

Camera camera_of(const Parameters& parameters, const CalibrationOptions& options) {
  if (!options.lens) return {options.width, options.height, parameters};
  return {options.width, options.height, parameters, options.lens->principal_point};
}

struct Fit {
  Parameters parameters;
  Eigen::Matrix<double, 10, 10> information;  // J^T J in units of 1 px noise, priors included
  double data_square = 0.0;                   // px^2
};

// From where the camera says a reference is seen to where it was, px.
Eigen::Vector2d miss(const Camera& camera, const CameraReference& reference) {
  return disc_centroid(camera, reference.x, reference.z, reference.diameter) - reference.pixel;
}

Fit fit_camera(const std::vector<CameraReference>& references,
               const CalibrationOptions& options,
               const Prior& prior,
               Parameters parameters) {
  const int rows = 2 * static_cast<int>(references.size());
  const auto residuals_of = [&](const Parameters& p) {
    Eigen::VectorXd residuals(rows);
    const Camera camera = camera_of(p, options);
    for (std::size_t i = 0; i < references.size(); ++i)
      residuals.segment<2>(2 * static_cast<int>(i)) = miss(camera, references[i]);
    return residuals;
  };
  const Parameters prior_weight = (options.expected_sigma_px / prior.sigma.array()).matrix();
  const auto cost_of = [&](const Parameters& p, const Eigen::VectorXd& residuals) {
    return residuals.squaredNorm() + prior_weight.cwiseProduct(p - prior.mean).squaredNorm();
  };
  Eigen::VectorXd residuals = residuals_of(parameters);
  double cost = cost_of(parameters, residuals);
  double damping = 1.0e-3;
  Eigen::Matrix<double, 10, 10> information;
  constexpr int most_steps = 60;
  // Relative. Of a cost in px^2 a step less would leave residuals a millionth of a pixel off
  constexpr double to_rounding = 1.0e-16;
  for (int step = 0; step < most_steps; ++step) {
    Eigen::MatrixXd jacobian(rows, parameter_count);
    for (int k = 0; k < parameter_count; ++k) {
      // Five points: as far apart as this their rounding does not reach the residuals' millionth of
      // a pixel, even where clicks hardly tell a parameter
      const auto moved = [&](double change) {
        Parameters changed = parameters;
        changed[k] += change;
        return residuals_of(changed);
      };
      const double delta = 1.0e-3;
      jacobian.col(k) =
          (8.0 * (moved(delta) - moved(-delta)) - (moved(2.0 * delta) - moved(-2.0 * delta))) /
          (12.0 * delta);
    }
    information = jacobian.transpose() * jacobian;
    information.diagonal() += prior_weight.cwiseAbs2();
    Parameters gradient = jacobian.transpose() * residuals;
    gradient += prior_weight.cwiseAbs2().cwiseProduct(parameters - prior.mean);
    bool improved = false;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      Eigen::Matrix<double, 10, 10> damped = information;
      damped.diagonal() *= 1.0 + damping;
      const Parameters change = damped.ldlt().solve(-gradient);
      const Parameters tried = parameters + change;
      const Eigen::VectorXd tried_residuals = residuals_of(tried);
      const double tried_cost = cost_of(tried, tried_residuals);
      if (std::isfinite(tried_cost) && tried_cost < cost) {
        improved = cost - tried_cost > to_rounding * cost;
        parameters = tried;
        residuals = tried_residuals;
        cost = tried_cost;
        damping = std::max(1.0e-9, damping * 0.2);
        if (!improved) break;
      } else {
        damping *= 8.0;
      }
    }
    if (!improved) break;
  }
  return {parameters, information, residuals.squaredNorm()};
}

std::vector<CameraReference> without(std::vector<CameraReference> references, std::size_t one) {
  references.erase(references.begin() + static_cast<std::ptrdiff_t>(one));
  return references;
}

// Similarity from the references: enough to start the fit from.
Parameters starting_parameters(const std::vector<CameraReference>& references,
                               const CalibrationOptions& options,
                               const Prior& prior) {
  // Least squares for q = s * Rot * p + t with q = (a * column, -row); complex numbers keep it to
  // two lines.
  const double aspect = std::exp(prior.mean[1]);
  const Eigen::Vector2d centre = camera_of(prior.mean, options).principal_point();
  Eigen::Vector2d mean_lab = Eigen::Vector2d::Zero(), mean_picture = Eigen::Vector2d::Zero();
  const auto lab = [](const CameraReference& r) { return Eigen::Vector2d(r.x, r.z); };
  const auto picture = [&](const CameraReference& r) {
    return Eigen::Vector2d(aspect * (r.pixel.x() - centre.x()), -(r.pixel.y() - centre.y()));
  };
  for (const CameraReference& r : references) {
    mean_lab += lab(r) / static_cast<double>(references.size());
    mean_picture += picture(r) / static_cast<double>(references.size());
  }
  double real = 0.0, imaginary = 0.0, square = 0.0;
  for (const CameraReference& r : references) {
    const Eigen::Vector2d p = lab(r) - mean_lab, q = picture(r) - mean_picture;
    real += p.dot(q);
    imaginary += p.x() * q.y() - p.y() * q.x();
    square += p.squaredNorm();
  }
  const double scale = std::hypot(real, imaginary) / square;  // px/m
  const double turn = std::atan2(imaginary, real);
  const Eigen::Rotation2Dd rotation(turn);
  const Eigen::Vector2d foot = mean_lab - rotation.inverse() * (mean_picture / scale);
  Parameters start = prior.mean;
  start[4] = -turn;  // the camera's forward axis points away from the lab's h axis
  start[5] = foot.x();
  start[6] = foot.y();
  start[7] = std::log(std::exp(start[0]) / scale);
  return start;
}

}  // namespace

Camera::Camera(int width, int height, const Parameters& parameters)
    : Camera(width, height, parameters, {0.5 * (width - 1), 0.5 * (height - 1)}) {}

Camera::Camera(int width,
               int height,
               const Parameters& parameters,
               const Eigen::Vector2d& principal_point)
    : width_(width), height_(height), parameters_(parameters), principal_point_(principal_point) {
  focal_ = std::exp(parameters[0]);
  aspect_ = std::exp(parameters[1]);
  // Right, down, forward from right, up, towards the camera.
  rotation_ =
      rotation_matrix(parameters.segment<3>(2)) * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  // The foot (x, z, 0) of the optical axis is seen straight ahead, at the stated distance.
  const Eigen::Vector3d foot(parameters[5], parameters[6], 0.0);
  translation_ = Eigen::Vector3d(0.0, 0.0, std::exp(parameters[7])) - rotation_ * foot;
  position_ = -rotation_.transpose() * translation_;
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d seen = rotation_ * point + translation_;
  const double u = seen.x() / seen.z(), v = seen.y() / seen.z();
  const double square = u * u + v * v;
  const double stretch = 1.0 + square * (parameters_[8] + parameters_[9] * square);
  return {principal_point_.x() + focal_ / aspect_ * u * stretch,
          principal_point_.y() + focal_ * v * stretch};
}

Eigen::Vector2d Camera::unproject(const Eigen::Vector2d& pixel) const {
  const double distorted_u = (pixel.x() - principal_point_.x()) * aspect_ / focal_;
  const double distorted_v = (pixel.y() - principal_point_.y()) / focal_;
  // Undo the distortion by fixed-point iteration: it shrinks the error by the distortion itself, a
  // few per cent.
  double u = distorted_u, v = distorted_v;
  for (int i = 0; i < 12; ++i) {
    const double square = u * u + v * v;
    const double stretch = 1.0 + square * (parameters_[8] + parameters_[9] * square);
    u = distorted_u / stretch;
    v = distorted_v / stretch;
  }
  const Eigen::Vector3d direction = rotation_.transpose() * Eigen::Vector3d(u, v, 1.0);
  const double reach = -position_.z() / direction.z();
  return (position_ + reach * direction).head<2>();
}

Eigen::Matrix2d Camera::jacobian(double x, double z) const {
  const double delta = 1.0e-5;  // m; the map is smooth over centimetres
  Eigen::Matrix2d result;
  result.col(0) = (project(x + delta, z) - project(x - delta, z)) / (2.0 * delta);
  result.col(1) = (project(x, z + delta) - project(x, z - delta)) / (2.0 * delta);
  return result;
}

double Camera::scale(double x, double z) const {
  return std::sqrt(std::abs(jacobian(x, z).determinant()));
}

void sphere_outline(const Camera& camera,
                    double x,
                    double z,
                    double radius,
                    std::vector<Eigen::Vector2d>& outline) {
  const Eigen::Vector3d centre(x, z, 0.0);
  const Eigen::Vector3d sight = centre - camera.position();
  const double square = sight.squaredNorm();
  const Eigen::Vector3d forward = sight / std::sqrt(square);
  const Eigen::Vector3d circle_centre = centre - sight * (radius * radius / square);
  const double circle_radius = radius * std::sqrt(std::max(0.0, 1.0 - radius * radius / square));
  const Eigen::Vector3d right = (Eigen::Vector3d::UnitX() - forward.x() * forward).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const auto count = static_cast<double>(outline.size());
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / count;
    outline[k] = camera.project(circle_centre +
                                circle_radius * (std::cos(angle) * right + std::sin(angle) * up));
  }
}

Eigen::Vector2d disc_centroid(const Camera& camera, double x, double z, double diameter) {
  constexpr int corners = 24;
  const Eigen::Vector2d origin = camera.project(x, z);
  if (diameter == 0.0) return origin;
  double area = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const auto corner = [&](int k) -> Eigen::Vector2d {
    const double angle = 2.0 * std::numbers::pi * k / corners;
    return camera.project(x + 0.5 * diameter * std::cos(angle),
                          z + 0.5 * diameter * std::sin(angle)) -
           origin;
  };
  Eigen::Vector2d previous = corner(0);
  for (int k = 1; k <= corners; ++k) {
    const Eigen::Vector2d next = corner(k % corners);
    const double cross = previous.x() * next.y() - previous.y() * next.x();
    area += cross / 2.0;
    moment += cross * (previous + next) / 6.0;
    previous = next;
  }
  return origin + moment / area;
}

Eigen::Matrix2d Calibration::point_covariance(double x, double z) const {
  Eigen::Matrix<double, 2, 10> derivative;
  for (int k = 0; k < parameter_count; ++k) {
    Parameters forward = camera.parameters(), backward = camera.parameters();
    const double delta = 1.0e-6;
    forward[k] += delta;
    backward[k] -= delta;
    const auto seen_with = [&](const Parameters& p) {
      return Camera(camera.width(), camera.height(), p, camera.principal_point()).project(x, z);
    };
    derivative.col(k) = (seen_with(forward) - seen_with(backward)) / (2.0 * delta);
  }
  const Eigen::Matrix2d plane_from_pixel = camera.jacobian(x, z).inverse();
  return plane_from_pixel * derivative * covariance * derivative.transpose() *
         plane_from_pixel.transpose();
}

Calibration calibrate(const std::vector<CameraReference>& references,
                      const CalibrationOptions& options) {
  if (references.size() < fewest_references) {
    throw datasets::InputError(
        fmt::format("camera: {} usable points of known place; at least {} are needed to calibrate "
                    "the camera, 8 or more are better",
                    references.size(),
                    fewest_references));
  }
  const Prior prior = camera_prior(options);
  std::vector<CameraReference> kept = references;
  Fit fit;
  Calibration result;
  // 1. Fit, and while one reference spoils it leave that one out
  while (true) {
    fit = fit_camera(kept, options, prior, starting_parameters(kept, options, prior));
    result.camera = camera_of(fit.parameters, options);
    result.residuals.clear();
    for (const CameraReference& r : kept)
      result.residuals.push_back(
          (result.camera.jacobian(r.x, r.z).inverse() * miss(result.camera, r)).norm());
    // What was mismeasured bends the whole fit: left out, the others agree much better. With good
    // references one less changes little; what may be expected of them is never worth one.
    const double rms_px = std::sqrt(fit.data_square / (2.0 * static_cast<double>(kept.size())));
    if (kept.size() <= fewest_references || rms_px < 2.0 * options.expected_sigma_px) break;
    double least = fit.data_square;
    std::size_t culprit = kept.size();
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const double square =
          fit_camera(without(kept, i), options, prior, fit.parameters).data_square;
      if (square < least) {
        least = square;
        culprit = i;
      }
    }
    constexpr double plain_gain = 4.0;  // halves the scatter
    if (culprit == kept.size() || plain_gain * least > fit.data_square) break;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(culprit));
  }
  // 2. Scatter, residuals in millimetres, and what each would have been predicted to be by the
  // others
  const double freedom = std::max(2.0, 2.0 * static_cast<double>(kept.size()) - 8.0);
  result.pixel_sigma = std::max(std::sqrt(fit.data_square / freedom), options.least_sigma_px);
  result.covariance = fit.information.inverse() * result.pixel_sigma * result.pixel_sigma;
  double square = 0.0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    result.used.push_back(kept[i].number);
    square += result.residuals[i] * result.residuals[i];
    result.max = std::max(result.max, result.residuals[i]);
  }
  result.rms = std::sqrt(square / static_cast<double>(kept.size()));
  if (kept.size() > fewest_references) {
    double left_out_square = 0.0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const Camera camera = camera_of(
          fit_camera(without(kept, i), options, prior, fit.parameters).parameters, options);
      const CameraReference& r = kept[i];
      const double error = (camera.jacobian(r.x, r.z).inverse() * miss(camera, r)).norm();
      left_out_square += error * error;
      result.leave_one_out_max = std::max(result.leave_one_out_max, error);
    }
    result.leave_one_out_rms = std::sqrt(left_out_square / static_cast<double>(kept.size()));
  }
  return result;
}

// Seen from unit distance the stick has some length L_1 in the plane; from a distance d it has d
// L_1, and so has every other length. The distance alone is uncertain, and the foot of the optical
// axis goes with it:
//   d = L / L_1,   d(foot) = foot d(log d).
Calibration level_camera(const KnownLength& known, const CalibrationOptions& options) {
  Parameters parameters = camera_prior(options).mean;
  const Camera near = camera_of(parameters, options);
  const double distance =
      known.length / (near.unproject(known.from) - near.unproject(known.to)).norm();
  parameters[7] = std::log(distance);
  parameters.segment<2>(5) = -distance * near.unproject(known.origin);
  Parameters slope = Parameters::Zero();
  slope.segment<2>(5) = parameters.segment<2>(5);
  slope[7] = 1.0;
  Calibration result;
  result.camera = camera_of(parameters, options);
  result.rms = result.max = result.leave_one_out_rms = result.leave_one_out_max =
      std::numeric_limits<double>::quiet_NaN();
  result.covariance = slope * slope.transpose() * known.relative_sigma * known.relative_sigma;
  return result;
}

MeasuredLength measure_length(const Calibration& calibration,
                              const Eigen::Vector2d& from,
                              const Eigen::Vector2d& to,
                              double click_error) {
  const Camera& camera = calibration.camera;
  const auto seen_by = [](const Camera& one, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (one.unproject(a) - one.unproject(b)).norm();
  };
  double variance = 0.0;
  // 1. The clicks
  constexpr double pixel = 0.5;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = pixel * Eigen::Vector2d::Unit(axis);
    const double by_from = seen_by(camera, from + step, to) - seen_by(camera, from - step, to);
    const double by_to = seen_by(camera, from, to + step) - seen_by(camera, from, to - step);
    variance += (by_from * by_from + by_to * by_to) * click_error * click_error;
  }
  // 2. The camera
  Parameters slope;
  for (int k = 0; k < parameter_count; ++k) {
    constexpr double delta = 1.0e-6;
    const auto with = [&](double change) {
      Parameters changed = camera.parameters();
      changed[k] += change;
      return seen_by(
          {camera.width(), camera.height(), changed, camera.principal_point()}, from, to);
    };
    slope[k] = (with(delta) - with(-delta)) / (2.0 * delta);
  }
  variance += slope.dot(calibration.covariance * slope);
  return {seen_by(camera, from, to), std::sqrt(variance)};
}

}  // namespace graintruth::tracking
