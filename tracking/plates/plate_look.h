// What a plate looks like: contrast over the plate, seen from the plate, in units of its own
// brightness. Rims, holes and the blur of the lens are in it, because it is learned from the film.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <vector>

#include "tracking/plates/plate.h"

namespace graintruth::tracking {

// What the lamps add on one side of a plate and take away on the other, in units of the plate's own
// brightness: light(p) = side(r) . n, with r = sqrt(u^2 + v^2) and n the outline's normal there, in
// the laboratory's frame (x, z). Rims, bevels and cast shadows do this; it turns not with the
// plate.
struct SideLight {
  static constexpr int nodes = 27;  // r = 0, 0.05, ... 1.3
  static constexpr float spacing = 0.05F;
  std::array<Eigen::Vector2f, nodes> side;

  SideLight() { side.fill(Eigen::Vector2f::Zero()); }
  Eigen::Vector2f at(float r) const {
    const float node = r / spacing;
    const auto i = static_cast<std::size_t>(std::min(static_cast<int>(node), nodes - 2));
    const float t = node - static_cast<float>(i);
    return (1.0F - t) * side[i] + t * side[i + 1];
  }
};

// The outline's normal at (u, v) of a plate, in its own frame.
inline Eigen::Vector2f outline_normal(float u, float v, const PlateShape& shape) {
  return Eigen::Vector2f(u / static_cast<float>(shape.semi_major),
                         v / static_cast<float>(shape.semi_minor))
      .normalized();
}

class PlateLook {
 public:
  // Body coordinates (u, v) are lengths along the two axes over the half axes; the look reaches out
  // to u^2 + v^2 = reach^2 and is zero beyond.
  static constexpr double reach = 1.3;

  struct Sample {
    float value, along_u, along_v;  // and derivatives
    float cover;                    // 1 on the plate, 0 off it, blurred alike
  };

  // A plain disc whose edge is blurred by a Gaussian of `edge_u` (in body coordinates).
  explicit PlateLook(double edge_u);

  Sample at(float u, float v) const {
    const float column = (u + limit) * to_grid, row = (v + limit) * to_grid;
    const int i = static_cast<int>(column), j = static_cast<int>(row);
    const float s = column - static_cast<float>(i), t = row - static_cast<float>(j);
    const Sample* top = &samples_[static_cast<std::size_t>(j * size + i)];
    const Sample* bottom = top + size;
    const float a = (1 - s) * (1 - t), b = s * (1 - t), c = (1 - s) * t, d = s * t;
    return {a * top[0].value + b * top[1].value + c * bottom[0].value + d * bottom[1].value,
            a * top[0].along_u + b * top[1].along_u + c * bottom[0].along_u + d * bottom[1].along_u,
            a * top[0].along_v + b * top[1].along_v + c * bottom[0].along_v + d * bottom[1].along_v,
            a * top[0].cover + b * top[1].cover + c * bottom[0].cover + d * bottom[1].cover};
  }

  // Mean look of many plates, gathered pixel by pixel.
  class Gatherer {
   public:
    Gatherer();
    // `contrast` of a pixel at (u, v) of a plate of brightness `gain`.
    void add(float u, float v, float contrast, float gain);
    // Least squares of contrast = gain * look at every grid point; a look is the same after half a
    // turn, so that it has no direction of its own to drift to. Where nothing was seen `before` is
    // kept.
    PlateLook look(const PlateLook& before) const;

   private:
    std::vector<float> products_, squares_;
  };

  // This look with the light on it as it falls on a plate at `angle`.
  PlateLook lit(const SideLight& light, double angle, const PlateShape& shape) const;

  // The radius, in body coordinates, at which the mean look falls through half of its value just
  // inside the rim: 1 where the stated size is right and edges are even.
  double edge_radius() const;

 private:
  static constexpr int size = 112;  // grid points a side: two a pixel for plates 40 pixels long
  static constexpr float limit = 1.36F;
  static constexpr float to_grid = static_cast<float>(size - 1) / (2.0F * limit);

  PlateLook() = default;
  void differentiate();

  std::vector<Sample> samples_;
  friend class Gatherer;
};

// A look under the light of a film, for plates at any angle.
class LitLook {
 public:
  LitLook(const PlateLook& look, const SideLight& light, const PlateShape& shape);
  explicit LitLook(const PlateLook& look) : looks_{look} {}

  // For `angle` in [0, pi): steps of a few degrees of the light's direction.
  const PlateLook& at(double angle) const;

 private:
  std::vector<PlateLook> looks_;
};

// Separates light from displacement: both make one edge of every plate brighter and the other
// darker, but holes and corners move with the displacement and not with the light, and light has no
// step at the edge of its own. Least squares over the pixels of all plates of
//   rest = -slope . shift + side(r) . n,
// the shift common to all, `side` smooth.
class LightGatherer {
 public:
  LightGatherer() : matrix_(Matrix::Zero()), right_(Vector::Zero()) {}
  // `rest` is what the model leaves, and `slope` the model's derivative over (x, z), both over the
  // plate's brightness; lengths in semi-minor axes.
  void add(float r, const Eigen::Vector2f& normal, const Eigen::Vector2f& slope, float rest);
  SideLight light(const SideLight& before) const;

 private:
  static constexpr int unknowns = 2 + 2 * SideLight::nodes;
  using Matrix = Eigen::Matrix<double, unknowns, unknowns>;
  using Vector = Eigen::Matrix<double, unknowns, 1>;
  Matrix matrix_;
  Vector right_;
  double count_ = 0.0;
};

}  // namespace graintruth::tracking
