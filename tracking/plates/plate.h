// An elliptical plate that stands in the picture plane, and when two of them touch.
#pragma once

#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

// Half axes of the outline, m.
struct PlateShape {
  double semi_major = 0.0, semi_minor = 0.0;

  bool shows_angle() const {
    return datasets::EllipticalPlate{semi_major, semi_minor, 0.0}.shows_angle();
  }
};

// Of a body of kind "plate".
PlateShape plate_shape(const datasets::SeenBody& body);

// The factor by which both plates would have to grow about their centres to touch: below 1 they
// overlap, 1 is contact (Perram and Wertheim 1985, J. Comput. Phys. 58).
double touching_scale(const datasets::Pose& one,
                      const datasets::Pose& other,
                      const PlateShape& shape);

}  // namespace graintruth::tracking
