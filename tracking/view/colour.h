// Colours as brightness and two differences, in which shades of one paint lie near each other.
#pragma once

#include <Eigen/Dense>

namespace graintruth::tracking {

// Y, Cr, Cb of ITU-R BT.601; grey has no Cr and no Cb.
inline Eigen::Vector3f luma_and_chroma(double blue, double green, double red) {
  const double luma = 0.299 * red + 0.587 * green + 0.114 * blue;
  return Eigen::Vector3d(luma, 0.713 * (red - luma), 0.564 * (blue - luma)).cast<float>();
}

}  // namespace graintruth::tracking
