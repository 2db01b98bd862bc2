// A chessboard: the lens from pictures of one that was held anywhere, the corners of one that lies
// in the plane of the particles.
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace graintruth::tracking {

struct Lens {
  double focal_px = 0.0;                // of square pixels
  Eigen::Vector2d principal_point;      // px
  double focal_sigma_px = 0.0;          // standard deviation
  double k1 = 0.0, k2 = 0.0, k3 = 0.0;  // radial (Brown 1966)
  double k1_sigma = 0.0, k2_sigma = 0.0;
  double p1 = 0.0, p2 = 0.0;                     // tangential
  double rms_px = 0.0;                           // reprojection, of the views that were used
  cv::Size size;                                 // px, of the pictures
  std::vector<std::filesystem::path> used;       // views
  std::filesystem::path worst;                   // the view that fits worst before any is left out
  double worst_px = 0.0, median_px = 0.0;        // its residual, and that of a usual view
  std::vector<std::filesystem::path> unseen;     // no whole board was found in them
  std::vector<std::filesystem::path> discarded;  // their board fits the others' lens too badly
};

// Which terms of the distortion are looked for; the others are 0.
enum class Distortion { radial_and_tangential, two_radial_terms };

// From pictures of one board of `columns` x `rows` inner corners and one camera. A view whose own
// residual exceeds three times the median of all views is left out, and the lens found again.
// Throws InputError where fewer than three views remain.
Lens calibrate_lens(const std::vector<std::filesystem::path>& views,
                    int columns,
                    int rows,
                    Distortion distortion = Distortion::radial_and_tangential);

// The inner corners of a board, row by row from its lower left one as the camera sees it; of a
// board that lies on its side the rows are those of the picture. None where no whole board is seen.
struct BoardCorner {
  int column = 0, row = 0;
  Eigen::Vector2d pixel;
};
std::vector<BoardCorner> find_board(const cv::Mat& grey, int columns, int rows);

}  // namespace graintruth::tracking
