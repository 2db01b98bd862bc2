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
  int ground_px = 0;         // odd; the mean over such a square is ground; 0: over a diameter
  double noise_px = 1.0;     // width of the Gaussian that smooths the camera's noise
  double percentile = 64.0;  // of the pixels that pass the band; maxima below it are ground
  double least_mass = 0.0;   // grey levels summed over the spot; 0: the gap in the masses decides
};

struct Spot {
  Eigen::Vector2d pixel;  // column, row; integers at pixel centres
  double mass = 0.0;      // grey levels above the ground, summed over the spot
};

// What a frame would show without particles: the median over a square of three diameters, of which
// they must cover less than half.
cv::Mat local_ground(const cv::Mat& frame, int diameter_px);

// How far each pixel's colour lies from that ground, grey levels, CV_32F, so that a particle of any
// colour stands out of a ground that changes slowly.
cv::Mat contrast_to_ground(const cv::Mat& frame, int diameter_px);

// The spots of a picture of one channel in which particles are bright, strongest first.
std::vector<Spot> locate_spots(const cv::Mat& picture, const SpotOptions& options);

// The mass that parts particles from dirt: the middle of the widest gap between masses that follow
// each other, as ratios. Particles of several kinds may differ, but not by as much as from dirt.
double gap_in_masses(const std::vector<Spot>& spots, int diameter_px);

// Moves each spot to the centre of area of the disc that it lies on: of what stands out of the
// ground
// (`contrast`, with noise of that many grey levels) within the diameter, where no other spot is
// nearer. Half of a disc's own contrast counts as much as all of it, so that what a disc carries on
// its face does not pull. Returns the white noise's standard deviation of each, px per axis.
std::vector<double> centre_on_discs(const cv::Mat& contrast,
                                    double diameter_px,
                                    double noise,
                                    std::vector<Spot>& spots);

// How many of the spots, strongest first, are particles where `count` of them lie there. Some may
// be hidden: then dirt follows that is less than half as strong as the weakest particle.
std::size_t particles_among(const std::vector<Spot>& spots, int count);

}  // namespace graintruth::tracking
