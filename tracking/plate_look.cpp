#include "tracking/plate_look.h"

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
