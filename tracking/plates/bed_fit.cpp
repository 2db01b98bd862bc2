#include "tracking/plates/bed_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace graintruth::tracking {

namespace {

// The ground beside a plate is as dark as anywhere, give or take shade: grey levels.
constexpr double ground_spread = 6.0;

constexpr float reach_square = static_cast<float>(PlateLook::reach * PlateLook::reach);

}  // namespace

BedFit::BedFit(
    const BedView& view, const LitLook& look, cv::Mat1f contrast, int first_row, int row_step)
    : view_(view),
      look_(&look),
      residual_(std::move(contrast)),
      first_row_(first_row),
      row_step_(row_step) {}

BedFit::Placement BedFit::place(const datasets::Pose& pose) const {
  Placement placement;
  const Eigen::Vector2d centre =
      view_.camera->project(Eigen::Vector3d(pose.x, pose.z, view_.height));
  placement.centre = (centre - Eigen::Vector2d(view_.region.x, view_.region.y)).cast<float>();
  const Eigen::Matrix2d jacobian = view_.camera->jacobian(pose.x, pose.z);
  // A plate looks the same after half a turn
  const double angle = pose.angle - std::numbers::pi * std::floor(pose.angle / std::numbers::pi);
  const double c = std::cos(angle), s = std::sin(angle);
  placement.look = &look_->at(angle);
  Eigen::Matrix2d axes;  // from body coordinates to the plane
  axes << c * view_.shape.semi_major, -s * view_.shape.semi_minor, s * view_.shape.semi_major,
      c * view_.shape.semi_minor;
  const Eigen::Matrix2d to_pixel = jacobian * axes;
  placement.to_body = to_pixel.inverse().cast<float>();
  placement.cosine = static_cast<float>(c);
  placement.sine = static_cast<float>(s);
  const Eigen::Vector2d half = PlateLook::reach * to_pixel.rowwise().norm();
  const int left = static_cast<int>(std::ceil(placement.centre.x() - half.x()));
  const int right = static_cast<int>(std::floor(placement.centre.x() + half.x()));
  const int top = static_cast<int>(std::ceil(placement.centre.y() - half.y()));
  const int bottom = static_cast<int>(std::floor(placement.centre.y() + half.y()));
  placement.box = cv::Rect(left, top, right - left + 1, bottom - top + 1) &
                  cv::Rect(0, 0, residual_.cols, residual_.rows);
  return placement;
}

// Calls visit(row, column, index in the box, u, v) for every pixel of the region within reach.
template <typename Visit>
void BedFit::visit(const Placement& placement, Visit&& visit) const {
  const cv::Rect& box = placement.box;
  const float du = placement.to_body(0, 0), dv = placement.to_body(1, 0);
  for (int row = box.y; row < box.y + box.height; ++row) {
    const float y = static_cast<float>(row) - placement.centre.y();
    const float x = static_cast<float>(box.x) - placement.centre.x();
    float u = du * x + placement.to_body(0, 1) * y;
    float v = dv * x + placement.to_body(1, 1) * y;
    int index = (row - box.y) * box.width;
    for (int column = box.x; column < box.x + box.width; ++column, ++index, u += du, v += dv) {
      if (u * u + v * v >= reach_square) continue;
      visit(row, column, index, u, v);
    }
  }
}

void BedFit::draw(Plate& plate, float sign) {
  const cv::Rect& box = plate.placement.box;
  for (int row = 0; row < box.height; ++row) {
    float* to = residual_.ptr<float>(box.y + row) + box.x;
    const float* from = plate.drawn.data() + static_cast<std::ptrdiff_t>(row) * box.width;
    for (int column = 0; column < box.width; ++column) to[column] += sign * from[column];
  }
}

void BedFit::redraw(Plate& plate) {
  draw(plate, 1.0F);
  plate.placement = place(plate.fit.pose);
  plate.drawn.assign(static_cast<std::size_t>(plate.placement.box.area()), 0.0F);
  const auto gain = static_cast<float>(plate.fit.gain);
  const PlateLook& surface = *plate.placement.look;
  visit(plate.placement, [&](int, int, int index, float u, float v) {
    plate.drawn[static_cast<std::size_t>(index)] = gain * surface.at(u, v).value;
  });
  draw(plate, -1.0F);
}

std::size_t BedFit::add(const datasets::Pose& pose, double gain) {
  Plate& plate = plates_.emplace_back();
  plate.fit.pose = pose;
  plate.fit.gain = gain;
  plate.present = true;
  redraw(plate);
  return plates_.size() - 1;
}

void BedFit::remove(std::size_t index) {
  Plate& plate = plates_[index];
  if (!plate.present) return;
  draw(plate, 1.0F);
  plate.drawn.assign(plate.drawn.size(), 0.0F);
  plate.present = false;
}

void BedFit::move(std::size_t plate, const datasets::Pose& pose) {
  plates_[plate].fit.pose = pose;
  redraw(plates_[plate]);
}

void BedFit::restore(std::size_t plate, const PlateFit& fit) {
  plates_[plate].fit = fit;
  redraw(plates_[plate]);
}

void BedFit::set_look(const LitLook& look) {
  look_ = &look;
  for (Plate& plate : plates_)
    if (plate.present) redraw(plate);
}

double BedFit::sweep(double longest_step) {
  double longest = 0.0;
  for (std::size_t plate = 0; plate < plates_.size(); ++plate)
    if (plates_[plate].present) longest = std::max(longest, improve(plate, longest_step));
  return longest;
}

// Unknowns: steps of x, z (in semi-minor axes) and of the angle, the gain g and the ground's b:
//   contrast - others = g S + b (1 - cover) + g (dS/dx dx + dS/dz dz + dS/dangle dangle)
//   dS/dx = -(S_u cos / a - S_v sin / b),  dS/dz = -(S_u sin / a + S_v cos / b),
//   dS/dangle = S_u v b / a - S_v u a / b
double BedFit::improve(std::size_t index, double longest_step) {
  Plate& plate = plates_[index];
  const Placement& placement = plate.placement;
  const auto ratio = static_cast<float>(view_.shape.semi_minor / view_.shape.semi_major);
  const float c = placement.cosine, s = placement.sine;
  const auto gain = static_cast<float>(plate.fit.gain);
  const PlateLook& surface = *placement.look;
  // Lower triangle of the normal equations, and their right side
  float normal[15] = {}, right[5] = {};
  visit(placement, [&](int row, int column, int i, float u, float v) {
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const PlateLook::Sample look = surface.at(u, v);
    // Lengths in semi-minor axes: S_u cos / a = S_u cos (b / a) / b
    const float d[5] = {gain * (look.along_v * s - ratio * look.along_u * c),
                        gain * (-look.along_v * c - ratio * look.along_u * s),
                        gain * (look.along_u * v * ratio - look.along_v * u / ratio),
                        look.value,
                        1.0F - look.cover};
    const float seen = residual_(row, column) + plate.drawn[static_cast<std::size_t>(i)];
    int k = 0;
    for (int p = 0; p < 5; ++p) {
      right[p] += d[p] * seen;
      for (int q = 0; q <= p; ++q) normal[k++] += d[p] * d[q];
    }
  });
  Eigen::Matrix<double, 5, 5> matrix;
  Eigen::Matrix<double, 5, 1> side;
  int k = 0;
  for (int p = 0; p < 5; ++p) {
    side[p] = right[p];
    for (int q = 0; q <= p; ++q) matrix(p, q) = matrix(q, p) = normal[k++];
  }
  const double noise_square = 16.0;  // grey levels squared: what a prior competes with
  matrix(4, 4) += noise_square / (ground_spread * ground_spread);
  // Keeps steps finite where hardly anything can be seen
  for (int p = 0; p < 3; ++p) matrix(p, p) += 1.0e-3 * matrix(p, p) + 1.0;
  // A disc does not turn: light and shade on it would be taken for that.
  if (!view_.shape.shows_angle()) matrix(2, 2) += 1.0e12;
  matrix(3, 3) += 1.0e-3;
  const Eigen::Matrix<double, 5, 1> solution = matrix.ldlt().solve(side);
  if (!solution.allFinite()) return 0.0;
  const double b = view_.shape.semi_minor, a = view_.shape.semi_major;
  Eigen::Vector3d step(solution[0] * b, solution[1] * b, solution[2]);
  const double length = std::max(std::hypot(step[0], step[1]), std::abs(step[2]) * a);
  if (length > longest_step) step *= longest_step / length;
  plate.fit.pose.x += step[0];
  plate.fit.pose.z += step[1];
  plate.fit.pose.angle += step[2];
  plate.fit.gain = std::max(1.0, solution[3]);
  plate.fit.ground = solution[4];
  redraw(plate);
  return std::min(length, longest_step);
}

PlateFit BedFit::measure(std::size_t index) const {
  const Plate& plate = plates_[index];
  PlateFit fit = plate.fit;
  const auto ratio = static_cast<float>(view_.shape.semi_minor / view_.shape.semi_major);
  const float c = plate.placement.cosine, s = plate.placement.sine;
  const auto gain = static_cast<float>(fit.gain), ground = static_cast<float>(fit.ground);
  const PlateLook& surface = *plate.placement.look;
  Eigen::Matrix<double, 5, 5> matrix = Eigen::Matrix<double, 5, 5>::Zero();
  double unexplained = 0.0, own = 0.0, near = 0.0;
  int inside = 0, used = 0;
  visit(plate.placement, [&](int row, int column, int i, float u, float v) {
    const bool on_plate = u * u + v * v < 1.0F;
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const PlateLook::Sample look = surface.at(u, v);
    const Eigen::Matrix<float, 5, 1> d{gain * (look.along_v * s - ratio * look.along_u * c),
                                       gain * (-look.along_v * c - ratio * look.along_u * s),
                                       gain * (look.along_u * v * ratio - look.along_v * u / ratio),
                                       look.value,
                                       1.0F - look.cover};
    const Eigen::Matrix<double, 5, 1> row_of = d.cast<double>();
    matrix.selfadjointView<Eigen::Lower>().rankUpdate(row_of);
    const float rest = residual_(row, column) - ground * (1.0F - look.cover);
    near += rest * rest;
    ++used;
    if (!on_plate) return;
    ++inside;
    const float seen = residual_(row, column) + plate.drawn[static_cast<std::size_t>(i)];
    unexplained += rest * rest;
    own += seen * seen;
  });
  const double area =
      std::abs(1.0 / plate.placement.to_body.determinant()) * 3.14159265358979 / row_step_;
  fit.visible = std::min(1.0, inside / area);
  fit.score = own > 0.0 ? std::max(0.0, 1.0 - unexplained / own) : 0.0;
  fit.residual = std::sqrt(unexplained / std::max(1, inside));
  const double b = view_.shape.semi_minor;
  matrix(4, 4) += 16.0 / (ground_spread * ground_spread);
  for (int p = 0; p < 4; ++p) matrix(p, p) += 1.0e-3;
  const Eigen::Matrix<double, 5, 5> full = matrix.selfadjointView<Eigen::Lower>();
  const Eigen::Matrix3d inverse = full.inverse().topLeftCorner<3, 3>();
  const Eigen::Vector3d unit(b, b, 1.0);
  fit.covariance = (near / std::max(1, used - 5)) * unit.asDiagonal() * inverse * unit.asDiagonal();
  return fit;
}

BedFit::Variances BedFit::variances(std::size_t index) const {
  const Plate& plate = plates_[index];
  const auto ratio = static_cast<float>(view_.shape.semi_minor / view_.shape.semi_major);
  const float c = plate.placement.cosine, s = plate.placement.sine;
  const auto gain = static_cast<float>(plate.fit.gain);
  const auto ground = static_cast<float>(plate.fit.ground);
  const PlateLook& surface = *plate.placement.look;
  using Vector = Eigen::Matrix<double, 5, 1>;
  using Matrix = Eigen::Matrix<double, 5, 5>;
  constexpr int block = 6;  // pixels: transforms of video codecs are 4 or 8
  const cv::Rect& box = plate.placement.box;
  const int across = box.width / block + 1;
  std::vector<Vector> sums(static_cast<std::size_t>(across * (box.height / block + 1)),
                           Vector::Zero());
  Matrix matrix = Matrix::Zero();
  // The two parts: normal equations and right sides
  std::array<Matrix, 2> part_matrix = {Matrix::Zero(), Matrix::Zero()};
  std::array<Vector, 2> part_right = {Vector::Zero(), Vector::Zero()};
  constexpr float inner = 0.6F * 0.6F;
  double square = 0.0;
  int used = 0;
  visit(plate.placement, [&](int row, int column, int, float u, float v) {
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const PlateLook::Sample look = surface.at(u, v);
    const Eigen::Matrix<float, 5, 1> d{gain * (look.along_v * s - ratio * look.along_u * c),
                                       gain * (-look.along_v * c - ratio * look.along_u * s),
                                       gain * (look.along_u * v * ratio - look.along_v * u / ratio),
                                       look.value,
                                       1.0F - look.cover};
    const Vector slope = d.cast<double>();
    const double rest = residual_(row, column) - ground * (1.0F - look.cover);
    matrix.selfadjointView<Eigen::Lower>().rankUpdate(slope);
    const int cell = (row - box.y) / block * across + (column - box.x) / block;
    sums[static_cast<std::size_t>(cell)] += rest * slope;
    const std::size_t part = u * u + v * v < inner ? 0 : 1;
    part_matrix[part].selfadjointView<Eigen::Lower>().rankUpdate(slope);
    part_right[part] += rest * slope;
    square += rest * rest;
    ++used;
  });
  for (int p = 0; p < 5; ++p) matrix(p, p) += 1.0e-3;
  Matrix correlated = Matrix::Zero();
  for (const Vector& sum : sums) correlated += sum * sum.transpose();
  const Matrix inverse = Matrix(matrix.selfadjointView<Eigen::Lower>()).inverse();
  const Matrix sandwich = inverse * correlated * inverse;
  const double white = square / std::max(1, used - 5);
  Vector difference = Vector::Zero(), expected = Vector::Zero();
  std::array<Vector, 2> weight;  // of each part in the whole, by its information
  for (std::size_t part = 0; part < 2; ++part) {
    Matrix whole = part_matrix[part].selfadjointView<Eigen::Lower>();
    // Inside there is no ground
    for (int p = 0; p < 5; ++p) whole(p, p) += 1.0;
    const Matrix part_inverse = whole.inverse();
    difference += (part == 0 ? 1.0 : -1.0) * part_inverse * part_right[part];
    expected += white * part_inverse.diagonal();
    weight[part] = part_inverse.diagonal().cwiseInverse();
  }
  const Vector squares = weight[0].cwiseAbs2() + weight[1].cwiseAbs2();
  const Vector product = weight[0].cwiseProduct(weight[1]);
  return {(sandwich.diagonal().cwiseQuotient(white * inverse.diagonal())).head<3>(),
          difference.cwiseAbs2().cwiseQuotient(expected).head<3>(),
          (0.5 * squares.cwiseQuotient(product)).head<3>()};
}

double BedFit::gain_at(const datasets::Pose& pose, double* score) const {
  const Placement placement = place(pose);
  const PlateLook& surface = *placement.look;
  double product = 0.0, square = 0.0, seen_square = 0.0;
  visit(placement, [&](int row, int column, int, float u, float v) {
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const float value = surface.at(u, v).value, seen = residual_(row, column);
    product += value * seen;
    square += value * value;
    if (u * u + v * v < 1.0F) seen_square += seen * seen;
  });
  const double gain = square > 0.0 ? product / square : 0.0;
  if (score != nullptr)
    *score = seen_square > 0.0 ? product * std::max(0.0, gain) / seen_square : 0.0;
  return gain;
}

void BedFit::gather(std::size_t index,
                    const PlateLook& unlit,
                    PlateLook::Gatherer& gatherer) const {
  const Plate& plate = plates_[index];
  const auto gain = static_cast<float>(plate.fit.gain);
  const auto ground = static_cast<float>(plate.fit.ground);
  const PlateLook& surface = *plate.placement.look;
  visit(plate.placement, [&](int row, int column, int, float u, float v) {
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const float rest = residual_(row, column) - ground * (1.0F - surface.at(u, v).cover);
    gatherer.add(u, v, gain * unlit.at(u, v).value + rest, gain);
  });
}

void BedFit::gather(std::size_t index, LightGatherer& gatherer) const {
  const Plate& plate = plates_[index];
  const auto gain = static_cast<float>(plate.fit.gain);
  const auto ground = static_cast<float>(plate.fit.ground);
  const auto ratio = static_cast<float>(view_.shape.semi_minor / view_.shape.semi_major);
  const float c = plate.placement.cosine, s = plate.placement.sine;
  const PlateLook& surface = *plate.placement.look;
  visit(plate.placement, [&](int row, int column, int, float u, float v) {
    if ((row - first_row_) % row_step_ != 0 || !view_.usable(row, column)) return;
    const float r = std::hypot(u, v);
    if (r < 1.0e-3F) return;
    const PlateLook::Sample look = surface.at(u, v);
    const Eigen::Vector2f normal = outline_normal(u, v, view_.shape);
    const Eigen::Vector2f slope(look.along_u * c * ratio - look.along_v * s,
                                look.along_u * s * ratio + look.along_v * c);
    gatherer.add(r,
                 {c * normal.x() - s * normal.y(), s * normal.x() + c * normal.y()},
                 slope,
                 (residual_(row, column) - ground * (1.0F - look.cover)) / gain);
  });
}

}  // namespace graintruth::tracking
