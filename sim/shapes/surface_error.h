// How far a row of overlapping spheres is from the smooth body that it stands for
// (thesis 3.7, 3.8).
#pragma once

#include <span>

#include "sim/shapes/clump.h"

namespace graintruth::sim {

struct SurfaceError {
  // Sums of radii over distance, of the pair of neighbours that is farthest apart: for equal
  // spheres their diameter over their spacing (thesis 2.2). 0 for a single sphere.
  double sphere_density = 0.0;
  // rad; largest deviation of the contact normal from that of the smooth body, over all pairs of
  // neighbours, for a partner as large as the smallest sphere (thesis 3.16-3.19).
  double contact_normal = 0.0;
  // -; tan of it: the friction of a frictionless body whose lobes are climbed one after the other.
  // A bound: sliding at speed the thesis measured 0.71, 0.85 and 0.24 of it (Table 3.4).
  double pseudo_friction = 0.0;
};

// Deviation at the crease between neighbours of radii R1 and R2 at distance L, touched by a sphere
// of radius R, against the common tangent of the two (thesis 3.16-3.19; the larger of both sides):
//   theta = asin((R2 - R1)/L),  cos(alpha) = ((R1 + R)^2 + L^2 - (R2 + R)^2) / (2 (R1 + R) L)
//   gamma_1 = 90 deg + theta - alpha.   Equal spheres: asin(1/(2 q)).
// Zero when one sphere hides the other.
double contact_normal_error(double first_radius,
                            double second_radius,
                            double distance,
                            double partner_radius);

// Of spheres on one line; neighbours are those that follow one another along it.
SurfaceError surface_error_of(std::span<const ElementSphere> spheres);

}  // namespace graintruth::sim
