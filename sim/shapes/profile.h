// Element spheres for a body of revolution: circles along its profile, each tangent to it
// (thesis 2.2.2).
#pragma once

#include <vector>

#include "sim/shapes/clump.h"

namespace graintruth::sim {

struct ProfilePoint {
  double x = 0.0;  // m, along the axis
  double y = 0.0;  // m, half-width there
};

// Half-width along the axis from a table. Between its points y^2 is a cubic with the slopes of the
// parabolas through three points: exact for spheres, ellipsoids, cones and cylinders. Where that
// would take y^2 below zero it is the chord instead.
class Profile {
 public:
  // Throws std::invalid_argument with fewer than three points, when x does not increase, or when y
  // is below zero, or zero anywhere but at the ends.
  explicit Profile(std::vector<ProfilePoint> points);

  double from() const { return points_.front().x; }
  double to() const { return points_.back().x; }
  double half_width(double x) const;         // m
  double half_square_slope(double x) const;  // m; (y^2)'/2 = y y'

 private:
  struct Value {
    double square, slope;  // m2; m, of y^2
  };
  Value at(double x) const;

  std::vector<ProfilePoint> points_;
  std::vector<double> slope_;  // m; of y^2 at the points
};

// An ellipsoid's, by its half-lengths along and across the axis, m.
Profile ellipse_profile(double along, double across);

struct ProfileFit {
  std::vector<ElementSphere> spheres;  // centres on the x axis, in the frame of the table
  double chord = 0.0;                  // m; length of each
  double protrusion = 0.0;             // m; farthest that a sphere reaches outside the profile
  double shortfall = 0.0;              // m; deepest that the union stays inside it, across the axis
};

// Divides the profile into `chords` chords of equal length and makes the sphere that touches it at
// each inner division. Throws std::invalid_argument for fewer than two chords.
ProfileFit fit_profile(const Profile& profile, int chords);

// `count` equal spheres in a row whose length is `aspect_ratio` times their diameter and whose
// union has the given volume (m3)   (thesis 3.9.4). An aspect ratio of `count` has them just
// touching: R_n = R (1/n)^(1/3), thesis 5.1.
// Throws std::invalid_argument unless 1 < aspect_ratio <= count, or count is 1.
std::vector<ElementSphere> chain_of_volume(int count, double aspect_ratio, double volume);

}  // namespace graintruth::sim
