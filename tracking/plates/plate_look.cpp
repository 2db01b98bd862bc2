#include "tracking/plates/plate_look.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace graintruth::tracking {

namespace {
std::size_t cell(int row, int column, int size) {
  return static_cast<std::size_t>(row * size + column);
}
}  // namespace

PlateLook::PlateLook(double edge_u) {
  samples_.resize(static_cast<std::size_t>(size * size));
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double u = column / static_cast<double>(to_grid) - limit;
      const double v = row / static_cast<double>(to_grid) - limit;
      const double inside = (1.0 - std::hypot(u, v)) / (std::numbers::sqrt2 * edge_u);
      Sample& sample = samples_[cell(row, column, size)];
      sample.value = sample.cover = static_cast<float>(0.5 * std::erfc(-inside));
    }
  }
  differentiate();
}

void PlateLook::differentiate() {
  for (int row = 1; row + 1 < size; ++row) {
    for (int column = 1; column + 1 < size; ++column) {
      Sample& sample = samples_[cell(row, column, size)];
      sample.along_u = 0.5F * to_grid *
                       (samples_[cell(row, column + 1, size)].value -
                        samples_[cell(row, column - 1, size)].value);
      sample.along_v = 0.5F * to_grid *
                       (samples_[cell(row + 1, column, size)].value -
                        samples_[cell(row - 1, column, size)].value);
    }
  }
}

PlateLook PlateLook::lit(const SideLight& light, double angle, const PlateShape& shape) const {
  PlateLook result = *this;
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const float u = static_cast<float>(column) / to_grid - limit;
      const float v = static_cast<float>(row) / to_grid - limit;
      const float r = std::hypot(u, v);
      if (r < 1.0e-3F || r >= static_cast<float>(reach)) continue;
      const Eigen::Vector2f normal = outline_normal(u, v, shape);
      const Eigen::Vector2f in_laboratory(c * normal.x() - s * normal.y(),
                                          s * normal.x() + c * normal.y());
      result.samples_[cell(row, column, size)].value += light.at(r).dot(in_laboratory);
    }
  }
  result.differentiate();
  return result;
}

LitLook::LitLook(const PlateLook& look, const SideLight& light, const PlateShape& shape) {
  constexpr int directions = 36;  // five degrees of light direction change its effect by a tenth
  looks_.reserve(directions);
  for (int k = 0; k < directions; ++k)
    looks_.push_back(look.lit(light, std::numbers::pi * (k + 0.5) / directions, shape));
}

const PlateLook& LitLook::at(double angle) const {
  const auto count = static_cast<int>(looks_.size());
  const int k = static_cast<int>(angle / std::numbers::pi * count);
  return looks_[static_cast<std::size_t>(std::clamp(k, 0, count - 1))];
}

void LightGatherer::add(float r,
                        const Eigen::Vector2f& normal,
                        const Eigen::Vector2f& slope,
                        float rest) {
  const float node = r / SideLight::spacing;
  const int i = std::min(static_cast<int>(node), SideLight::nodes - 2);
  const float t = node - static_cast<float>(i);
  const int index[6] = {0, 1, 2 + 2 * i, 3 + 2 * i, 4 + 2 * i, 5 + 2 * i};
  const float factor[6] = {-slope.x(),
                           -slope.y(),
                           (1.0F - t) * normal.x(),
                           (1.0F - t) * normal.y(),
                           t * normal.x(),
                           t * normal.y()};
  for (int p = 0; p < 6; ++p) {
    right_[index[p]] += factor[p] * rest;
    for (int q = 0; q < 6; ++q) matrix_(index[p], index[q]) += factor[p] * factor[q];
  }
  count_ += 1.0;
}

SideLight LightGatherer::light(const SideLight& before) const {
  // Second differences of `side` (the light that was there before included) stay small against the
  // step that an edge makes: a hundredth of the pixels' own weight keeps the data in charge.
  Matrix matrix = matrix_;
  Vector right = right_;
  const double stiffness = 0.02 * count_ / SideLight::nodes;
  for (int i = 1; i + 1 < SideLight::nodes; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const int at[3] = {2 + 2 * (i - 1) + axis, 2 + 2 * i + axis, 2 + 2 * (i + 1) + axis};
      const double factor[3] = {1.0, -2.0, 1.0};
      double bend_before = 0.0;
      for (int p = 0; p < 3; ++p)
        bend_before += factor[p] * before.side[static_cast<std::size_t>(i - 1 + p)][axis];
      for (int p = 0; p < 3; ++p) {
        right[at[p]] -= stiffness * factor[p] * bend_before;
        for (int q = 0; q < 3; ++q) matrix(at[p], at[q]) += stiffness * factor[p] * factor[q];
      }
    }
  }
  for (int p = 0; p < unknowns; ++p) matrix(p, p) += 1.0e-6 * count_;
  const Vector solution = matrix.ldlt().solve(right);
  SideLight result = before;
  if (!solution.allFinite()) return result;
  for (int i = 0; i < SideLight::nodes; ++i)
    result.side[static_cast<std::size_t>(i)] += solution.segment<2>(2 + 2 * i).cast<float>();
  return result;
}

double PlateLook::edge_radius() const {
  constexpr int rays = 64;
  constexpr double step = 0.01;
  const auto mean_at = [&](double radius) {
    double sum = 0.0;
    for (int ray = 0; ray < rays; ++ray) {
      const double angle = 2.0 * std::numbers::pi * ray / rays;
      sum += at(static_cast<float>(radius * std::cos(angle)),
                static_cast<float>(radius * std::sin(angle)))
                 .value;
    }
    return sum / rays;
  };
  // The rim: the brightest ring of the outer part
  double plateau = 0.0;
  for (double radius = 0.7; radius < 0.95; radius += step)
    plateau = std::max(plateau, mean_at(radius));
  double radius = 0.8;
  while (radius < reach && mean_at(radius) > 0.5 * plateau) radius += step;
  const double outer = mean_at(radius), inner = mean_at(radius - step);
  return radius - step * (0.5 * plateau - outer) / (inner - outer);
}

PlateLook::Gatherer::Gatherer()
    : products_(static_cast<std::size_t>(size * size)),
      squares_(static_cast<std::size_t>(size * size)) {}

void PlateLook::Gatherer::add(float u, float v, float contrast, float gain) {
  // Once as seen and once turned by half a turn
  for (const float sign : {1.0F, -1.0F}) {
    const float column = (sign * u + limit) * to_grid, row = (sign * v + limit) * to_grid;
    const int i = static_cast<int>(column), j = static_cast<int>(row);
    const float s = column - static_cast<float>(i), t = row - static_cast<float>(j);
    const float weight[4] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
    const std::size_t at[4] = {
        cell(j, i, size), cell(j, i + 1, size), cell(j + 1, i, size), cell(j + 1, i + 1, size)};
    for (int corner = 0; corner < 4; ++corner) {
      products_[at[corner]] += weight[corner] * gain * contrast;
      squares_[at[corner]] += weight[corner] * gain * gain;
    }
  }
}

PlateLook PlateLook::Gatherer::look(const PlateLook& before) const {
  PlateLook result = before;
  const float most = *std::max_element(squares_.begin(), squares_.end());
  for (std::size_t i = 0; i < squares_.size(); ++i)
    if (squares_[i] > 0.02F * most) result.samples_[i].value = products_[i] / squares_[i];
  result.differentiate();
  return result;
}

}  // namespace graintruth::tracking
