// Isolated particles of one size on an even ground: band-pass, local maxima, iterated centre of
// mass (Crocker and Grier 1996, J. Colloid Interface Sci. 179, 298; as in trackpy 0.6). Good for
// particles that neither touch nor shine; balls and plates have locators of their own.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

namespace graintruth::tracking {

struct SpotOptions {
  int diameter_px = 11;      // odd; a little more than the particle's
  double noise_px = 1.0;     // width of the Gaussian that smooths the camera's noise
  double percentile = 64.0;  // of the pixels that pass the band; maxima below it are ground
  double least_mass = 0.0;   // grey levels summed over the spot; 0: the gap in the masses decides
};

struct Spot {
  Eigen::Vector2d pixel;  // column, row; integers at pixel centres
  double mass = 0.0;      // grey levels above the ground, summed over the spot
};

// How far each pixel's colour lies from that of the ground around it, grey levels, CV_32F; the
// ground is the median over a square of three diameters, so that a particle of any colour stands
// out of a ground that changes slowly.
cv::Mat contrast_to_ground(const cv::Mat& frame, int diameter_px);

// The spots of a picture of one channel in which particles are bright, strongest first.
std::vector<Spot> locate_spots(const cv::Mat& picture, const SpotOptions& options);

// The mass that parts particles from dirt: the middle of the widest gap between masses that follow
// each other, as ratios. Particles of several kinds may differ, but not by as much as from dirt.
double gap_in_masses(const std::vector<Spot>& spots, int diameter_px);

// Tracks of spots: each frame's spots are given to the tracks by the least total squared distance
// to where their last step leads, none farther than `reach_px` from it. A track waits `memory`
// frames for a spot that is not seen. Returns, for each track, the spot's index in each frame, -1
// where unseen.
std::vector<std::vector<int>> link_spots(const std::vector<std::vector<Spot>>& frames,
                                         double reach_px,
                                         int memory);

}  // namespace graintruth::tracking
