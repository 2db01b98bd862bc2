#include "sim/shapes/clump.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace graintruth::sim {
namespace {

// Below this share of the trace a product of inertia is round-off, and the axes of the input are
// kept.
constexpr double kPrincipalTolerance = 1e-12;

// Principal axes ordered and signed so that each lies as close as possible to the input axis of the
// same name.
Mat3 principal_axes(const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  const Mat3 vectors = solver.eigenvectors();
  std::array<int, 3> order{0, 1, 2}, best = order;
  double best_match = -1.0;
  do {
    double match = 0.0;
    for (int axis = 0; axis < 3; ++axis) match += std::abs(vectors(axis, order[axis]));
    if (match > best_match) {
      best_match = match;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  Mat3 axes;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 vector = vectors.col(best[axis]);
    axes.col(axis) = vector[axis] < 0.0 ? Vec3(-vector) : vector;
  }
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  return axes;
}

// Spheres that differ by less than this share of their radius are one: what is left of a place or a
// radius that was written down with nine digits.
constexpr double kTwinTolerance = 1e-9;

void merge_twins(std::vector<ElementSphere>& spheres) {
  std::vector<ElementSphere> single;
  for (const ElementSphere& sphere : spheres) {
    const bool is_twin = std::any_of(single.begin(), single.end(), [&](const ElementSphere& other) {
      return (sphere.centre - other.centre).norm() + std::abs(sphere.radius - other.radius) <=
             kTwinTolerance * sphere.radius;
    });
    if (!is_twin) single.push_back(sphere);
  }
  spheres = std::move(single);
}

}  // namespace

Clump make_clump(std::vector<ElementSphere> spheres, const MassChoice& choice, int material) {
  if (spheres.empty()) throw std::invalid_argument("make_clump: a clump needs at least one sphere");
  for (const ElementSphere& sphere : spheres) {
    if (!(sphere.radius > 0.0)) {
      throw std::invalid_argument("make_clump: radius is " + std::to_string(sphere.radius) +
                                  " m, must be above 0");
    }
  }
  const std::size_t given = spheres.size();
  merge_twins(spheres);

  // 1. Mass properties of the union at density 1
  const MassProperties shape = mass_properties_of_union(spheres);

  // 2. Principal axes; the input's own when they are principal
  Mat3 axes = Mat3::Identity();
  const double products =
      std::abs(shape.inertia(0, 1)) + std::abs(shape.inertia(0, 2)) + std::abs(shape.inertia(1, 2));
  if (products > kPrincipalTolerance * shape.inertia.trace()) axes = principal_axes(shape.inertia);

  // 3. Spheres in the body frame
  Clump clump;
  clump.smallest_radius = spheres.front().radius;
  for (ElementSphere& sphere : spheres) {
    sphere.centre = axes.transpose() * (sphere.centre - shape.centre);
    clump.bounding_radius = std::max(clump.bounding_radius, sphere.centre.norm() + sphere.radius);
    clump.smallest_radius = std::min(clump.smallest_radius, sphere.radius);
  }
  clump.spheres = std::move(spheres);
  clump.volume = shape.volume;
  clump.centre_in_input = shape.centre;
  clump.input_from_body = Quat(axes);
  clump.material = material;
  clump.merged_spheres = static_cast<int>(given - clump.spheres.size());

  // 4. Mass and inertia
  if (choice.mass) {
    clump.mass = *choice.mass;
  } else if (choice.density) {
    clump.mass = *choice.density * shape.volume;
  } else {
    throw std::invalid_argument("make_clump: give a mass or a density");
  }
  const Mat3 turned = axes.transpose() * shape.inertia * axes;
  clump.inertia =
      choice.inertia ? *choice.inertia : Vec3(turned.diagonal() * (clump.mass / shape.volume));
  if (!(clump.mass > 0.0 && clump.inertia.minCoeff() > 0.0)) {
    throw std::invalid_argument("make_clump: mass and inertia must be above 0");
  }
  return clump;
}

std::vector<ElementSphere> chain_of_spheres(int count, double radius, double spacing) {
  std::vector<ElementSphere> spheres;
  for (int i = 0; i < count; ++i) {
    spheres.push_back({Vec3((i - 0.5 * (count - 1)) * spacing, 0.0, 0.0), radius});
  }
  return spheres;
}

}  // namespace graintruth::sim
