// A clump: overlapping element spheres that move as one rigid body, with the mass properties of
// their union.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/types.h"

namespace graintruth::sim {

struct ElementSphere {
  Vec3 centre = Vec3::Zero();  // m, in the frame of the clump
  double radius = 0.0;         // m
};

// Of the union of spheres at density 1: overlap is counted once.
struct MassProperties {
  double volume = 0.0;          // m3
  Vec3 centre = Vec3::Zero();   // m
  Mat3 inertia = Mat3::Zero();  // m5; about the centre, I_xy = -int x y dV
};

// Exact for spheres on one line (piecewise polynomials of the union's profile); for any other
// arrangement slices with exact boundaries, Gauss-Legendre between all changes of topology, right
// to 1e-9 or better; above 24 spheres slices that are halved until they change by less than 1e-6.
MassProperties mass_properties_of_union(std::span<const ElementSphere> spheres);

// Replaces what the union and a density would give. A uniform density is scaled to `mass`;
// `inertia` is about the principal axes of the clump's frame, kg m2.
struct MassChoice {
  std::optional<double> density = std::nullopt;  // kg/m3
  std::optional<double> mass = std::nullopt;     // kg; wins over density
  std::optional<Vec3> inertia = std::nullopt;    // kg m2; wins over what follows from the mass
};

// The body frame has its origin in the centre of mass and its axes along the principal axes of
// inertia. The axes of the input are kept when they are principal, as for chains along x and shapes
// with two planes of symmetry.
struct Clump {
  std::vector<ElementSphere> spheres;   // in the body frame
  double mass = 0.0;                    // kg
  Vec3 inertia = Vec3::Zero();          // kg m2, principal
  double volume = 0.0;                  // m3, of the union
  double bounding_radius = 0.0;         // m, about the centre of mass
  double smallest_radius = 0.0;         // m
  int material = 0;                     // index into Scene::materials
  int merged_spheres = 0;               // that lay on another one of the input
  Vec3 centre_in_input = Vec3::Zero();  // m; where the origin of the body frame lay in the input
  Quat input_from_body = Quat::Identity();
};

// Spheres with the same centre and radius, to 1e-9 of it, are one: each would push.
// Throws std::invalid_argument when there is no sphere, a radius is not above zero, or neither mass
// nor density is given.
Clump make_clump(std::vector<ElementSphere> spheres, const MassChoice& choice, int material = 0);

// `count` equal spheres along the body x axis, `spacing` apart.
std::vector<ElementSphere> chain_of_spheres(int count, double radius, double spacing);

}  // namespace graintruth::sim
