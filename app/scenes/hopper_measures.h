// What chapter 5 of the thesis looks at in a hopper of one layer of grains: where the moving bed
// shears off what stays, and how steep a heap is. The middle of the hopper is at x = 0.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/engine/state.h"

namespace graintruth::app {

// Where the band of shear is looked for.
struct BandRegion {
  double height = 0.0;      // m; of the lower part of the hopper, above the floor at z = 0
  double row_height = 0.0;  // m; one place of the band a row and side
  double slow_share = 0.3;  // of the largest speed: grains below it are red in Figure 5.18
};

// Angle of the line between the slow grains at the sides and the faster ones inside, rad from the
// horizontal: pi/2 where it is vertical, less where it leans outwards, towards the walls. In each
// row and side the place that tells slow from fast with the fewest grains on the wrong side; a
// straight line through those of all states, side by side; the mean of both sides. None where
// fewer than three rows of a side have slow and fast grains.
std::optional<double> shear_band_angle(std::span<const sim::State> states,
                                       const BandRegion& region);

// Slope of a heap's surface down from the middle, rad: the median of the slopes between any two
// columns of the upper envelope (Theil-Sen), over columns between 0.15 and 0.85 of the half-width;
// the mean of both sides. None where a side has fewer than three columns with grains.
std::optional<double> heap_slope(std::span<const sim::Vec3> centres,
                                 double half_width,
                                 double column_width);

}  // namespace graintruth::app
