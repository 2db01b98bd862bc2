// A lens calibrated on pictures of a chessboard, for those who have one instead of fiducials in the
// plane of the particles.
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::tracking {

struct Lens {
  double focal_px = 0.0;                         // of square pixels
  Eigen::Vector2d principal_point;               // px
  double k1 = 0.0, k2 = 0.0, k3 = 0.0;           // radial (Brown 1966)
  double p1 = 0.0, p2 = 0.0;                     // tangential
  double rms_px = 0.0;                           // reprojection, of the views that were used
  std::vector<std::filesystem::path> used;       // views
  std::filesystem::path worst;                   // the view that fits worst before any is left out
  double worst_px = 0.0, median_px = 0.0;        // its residual, and that of a usual view
  std::vector<std::filesystem::path> unseen;     // no whole board was found in them
  std::vector<std::filesystem::path> discarded;  // their board fits the others' lens too badly
};

// From pictures of one board of `columns` x `rows` inner corners and one camera. A view whose own
// residual exceeds three times the median of all views is left out, and the lens found again.
// Throws InputError where fewer than three views remain.
Lens calibrate_lens(const std::vector<std::filesystem::path>& views, int columns, int rows);

}  // namespace graintruth::tracking
