// What a ball shows inside its outline - numerals, stripes, shading - as a second witness of where
// it is. Edges of the outline come and go with neighbours and shadows; the paint turns and moves
// with the body. Each frame's paint is compared with its mean over the whole clip, seen from the
// body.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <vector>

#include "tracking/balls/refine.h"

namespace graintruth::tracking {

// Where a ball is sampled: a square grid in the frame of the body, of the same points in every
// frame.
struct TextureGrid {
  struct Sample {
    double u, v;                    // along and across the axis, in radii
    std::array<int, 4> neighbours;  // towards -u, +u, -v, +v; -1 where there is none
  };
  std::size_t ball = 0;
  double step = 0.0;  // m, between neighbours
  std::vector<Sample> samples;
};

// `ball` 0 lies towards -axis; what lies near the seam is left out.
TextureGrid make_texture_grid(const BodyShape& shape, std::size_t ball);

// One ball as it looked in one frame, sampled on the sphere's front in the frame of the body.
struct TexturePatch {
  BodyPose pose;                     // at which it was sampled
  Eigen::Vector2d centre;            // of the ball then, m
  std::vector<std::int16_t> values;  // Y, Cr, Cb of every sample, sixteenths of a grey level
};

// Empty where the ball reaches out of the image.
TexturePatch sample_texture(const EdgeImage& image,
                            const Camera& camera,
                            const BodyShape& shape,
                            const BodyPose& pose,
                            const TextureGrid& grid);

// How far the ball lay from where it was sampled, against the mean of all patches: m, along and
// across the axis, one a patch. `information` is 1/m^2 of the residuals' own scatter; zero where
// nothing was sampled.
struct TextureShift {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

std::vector<TextureShift> align_textures(const std::vector<TexturePatch>& patches,
                                         const TextureGrid& grid);

// One body through the clip: every frame's pose from its outline and from what its balls show.
struct WitnessedPose {
  BodyPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle
};

struct BodyWitness {
  std::array<std::vector<TexturePatch>, 2> patches;  // one a frame
  std::array<TextureGrid, 2> grids;                  // that they were sampled on
  std::vector<WitnessedPose> outline;                // one a frame
  BodyShape shape;
};

// Joins the two witnesses for all bodies of a film. The texture tells how a ball moved between
// frames but not where in the texture its centre lies; the outline, averaged over the clip, tells
// that. Height of the texture above or below the sphere's front, and a camera distance that is a
// little off, make it move with the place in the picture: one factor for the film, found here too.
// Returns one list of poses a body.
std::vector<std::vector<WitnessedPose>> join_witnesses(const std::vector<BodyWitness>& bodies);

}  // namespace graintruth::tracking
