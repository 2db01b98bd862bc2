// What a ball shows inside its outline - numerals, stripes, shading - as a second witness of where
// it is. Edges of the outline come and go with neighbours and shadows; the paint turns and moves
// with the body, seen from which it is sampled.
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

  Eigen::Vector3f colour(std::size_t sample) const;  // Y, Cr, Cb, grey levels
};

// Empty where the ball reaches out of the image.
TexturePatch sample_texture(const EdgeImage& image,
                            const Camera& camera,
                            const BodyShape& shape,
                            const BodyPose& pose,
                            const TextureGrid& grid);

}  // namespace graintruth::tracking
