#include "tracking/view/texture.h"

#include <algorithm>
#include <cmath>

namespace graintruth::tracking {

namespace {

// The grid: samples every twelfth of a radius, out to where the sphere turns away too far to be
// seen well.
constexpr int samples_per_radius = 12;
constexpr double reach = 0.8;  // of the radius
constexpr float value_scale = 16.0F;

}  // namespace

Eigen::Vector3f TexturePatch::colour(std::size_t sample) const {
  const std::int16_t* value = &values[3 * sample];
  return Eigen::Vector3f(value[0], value[1], value[2]) / value_scale;
}

TextureGrid make_texture_grid(const BodyShape& shape, std::size_t ball) {
  constexpr int n = samples_per_radius;
  // A seventh of a radius short of the plane in which the two balls meet
  const double seam = 0.5 * shape.separation / shape.radius[ball] - 1.0 / 7.0;
  const double sign = ball == 0 ? 1.0 : -1.0;
  std::array<std::array<int, 2 * n + 1>, 2 * n + 1> at;
  for (auto& row : at) row.fill(-1);
  TextureGrid grid;
  grid.ball = ball;
  grid.step = shape.radius[ball] / samples_per_radius;
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      if (std::hypot(u, v) > reach || sign * u > seam) continue;
      at[static_cast<std::size_t>(i + n)][static_cast<std::size_t>(j + n)] =
          static_cast<int>(grid.samples.size());
      grid.samples.push_back({u, v, {}});
    }
  }
  const auto look = [&](int i, int j) {
    return std::abs(i) > n || std::abs(j) > n
               ? -1
               : at[static_cast<std::size_t>(i + n)][static_cast<std::size_t>(j + n)];
  };
  for (TextureGrid::Sample& s : grid.samples) {
    const int i = static_cast<int>(std::lround(s.u * n)),
              j = static_cast<int>(std::lround(s.v * n));
    s.neighbours = {look(i - 1, j), look(i + 1, j), look(i, j - 1), look(i, j + 1)};
  }
  return grid;
}

TexturePatch sample_texture(const EdgeImage& image,
                            const Camera& camera,
                            const BodyShape& shape,
                            const BodyPose& pose,
                            const TextureGrid& grid) {
  const std::size_t ball = grid.ball;
  TexturePatch patch;
  patch.pose = pose;
  patch.centre = ball_centres(pose, shape)[ball];
  const double radius = shape.radius[ball];
  const Eigen::Vector2d axis(std::cos(pose.angle), std::sin(pose.angle));
  const Eigen::Vector2d across(-axis.y(), axis.x());
  const Eigen::Vector2d& c = patch.centre;
  // Locally the camera is affine: pixel = middle + J (x, z) + parallax h, and what is nearer looks
  // larger.
  const Eigen::Vector2d middle = camera.project(c.x(), c.y());
  const Eigen::Matrix2d jacobian = camera.jacobian(c.x(), c.y());
  const Eigen::Vector2d parallax =
      (camera.project(Eigen::Vector3d(c.x(), c.y(), radius)) - middle);  // px a radius of height
  const double nearer = radius / camera.position().z();
  patch.values.reserve(3 * grid.samples.size());
  for (const TextureGrid::Sample& s : grid.samples) {
    const double height = std::sqrt(1.0 - s.u * s.u - s.v * s.v);
    const Eigen::Vector2d pixel =
        middle + (1.0 + nearer * height) * radius * (jacobian * (s.u * axis + s.v * across)) +
        height * parallax;
    if (!image.contains(pixel, 2.0)) {
      patch.values.clear();
      return patch;
    }
    const Eigen::Vector3f colour = value_scale * image.at(pixel);
    for (int channel = 0; channel < 3; ++channel)
      patch.values.push_back(static_cast<std::int16_t>(std::lround(colour[channel])));
  }
  return patch;
}

}  // namespace graintruth::tracking
