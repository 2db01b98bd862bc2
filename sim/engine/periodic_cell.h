// The cell of a periodic scene: what leaves it on one side comes back on the other, and what lies
// at the two ends of it are neighbours.
#pragma once

#include "sim/laws/motion.h"
#include "sim/scene.h"

namespace graintruth::sim {

// A sum of this with any |x| < 2^51 is whole. So (x + it) - it is the whole number nearest to x, of
// halves the even one: without a branch or a call, and loops run over several at once.
constexpr double kMakesWhole = 0x1.8p52;
inline double nearest_whole(double x) { return (x + kMakesWhole) - kMakesWhole; }

template <int D>
struct PeriodicCell {
  using Vector = typename Motion<D>::Vector;
  bool is_periodic = false;  // along any axis
  // m, m, 1/m; zero along the other axes
  Vector low = Motion<D>::no_vector(), length = low, inverse_length = low;
};

// What must be added to the end of `apart` (m) to make it as short as can be.
inline PlanarVector shift_to_nearest(const PeriodicCell<2>& cell, PlanarVector apart) {
  return {-cell.length.x * nearest_whole(apart.x * cell.inverse_length.x),
          -cell.length.z * nearest_whole(apart.z * cell.inverse_length.z)};
}
inline SpatialVector shift_to_nearest(const PeriodicCell<3>& cell, SpatialVector apart) {
  return {-cell.length.x * nearest_whole(apart.x * cell.inverse_length.x),
          -cell.length.y * nearest_whole(apart.y * cell.inverse_length.y),
          -cell.length.z * nearest_whole(apart.z * cell.inverse_length.z)};
}

// What must be added to a point (m) to bring it into the cell.
template <int D>
typename Motion<D>::Vector shift_into(const PeriodicCell<D>& cell,
                                      typename Motion<D>::Vector point) {
  return shift_to_nearest(cell, point - cell.low - 0.5 * cell.length);
}

template <int D>
PeriodicCell<D> periodic_cell(const Period& period) {
  const auto inverse = [](double length) { return length > 0.0 ? 1.0 / length : 0.0; };
  PeriodicCell<D> cell;
  cell.is_periodic = period.length.maxCoeff() > 0.0;
  cell.low = plain(to_motion<D>(period.low));
  cell.length = plain(to_motion<D>(period.length));
  cell.inverse_length = plain(to_motion<D>(Vec3(period.length.unaryExpr(inverse))));
  return cell;
}

// The shortest of all ways that `apart` (m) is between a point and the images of another.
inline Vec3 nearest(const Period& period, const Vec3& apart) {
  return apart + to_eigen(shift_to_nearest(periodic_cell<3>(period), plain(apart)));
}

}  // namespace graintruth::sim
