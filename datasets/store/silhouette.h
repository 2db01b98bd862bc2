// What a camera sees of a heap of spheres: the upper edge of their silhouette. A film's outline is
// compared with that of simulated grains, so both keep to the statistic of outline.h.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "datasets/store/outline.h"

namespace graintruth::datasets {

struct Ball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m; y away from the camera
  double radius = 0.0;                               // m
};

// A column that grains cover less than this, of its width, has no height: at the foot of a heap the
// edge of the last grain would stand for all of it.
inline constexpr double least_seen_share = 0.5;

// Of columns of equal width with these middles (m, rising in equal steps, at least two): the mean
// height (m) of the upper edge of the balls' shadows on the plane y = 0, cast from the eye, over
// the part of the column that they cover. NaN where that part is too small. Balls beside or behind
// the eye are not seen. The edge is sampled 32 times a column: for columns of half a ball's
// diameter that is exact to 0.1 % of the diameter, but for the two columns in which a lone ball's
// edge stands upright.
std::vector<double> silhouette(std::span<const Ball> balls,
                               std::span<const double> columns,
                               const Eye& eye);

}  // namespace graintruth::datasets
