// What a plate looks like: contrast over the plate, seen from the plate, in units of its own
// brightness. Rims, holes and the blur of the lens are in it, because it is learned from the film.
#pragma once

#include <vector>

namespace graintruth::tracking {

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

}  // namespace graintruth::tracking
