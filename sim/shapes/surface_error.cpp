#include "sim/shapes/surface_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/laws/elementary.h"

namespace graintruth::sim {
namespace {

double one_side(double first, double second, double distance, double partner) {
  const double theta = steady_asin((second - first) / distance);
  const double near = first + partner, far = second + partner;
  const double cosine = (near * near + distance * distance - far * far) / (2.0 * near * distance);
  const double alpha = steady_acos(std::clamp(cosine, -1.0, 1.0));
  return 0.5 * std::numbers::pi + theta - alpha;
}

}  // namespace

double contact_normal_error(double first_radius,
                            double second_radius,
                            double distance,
                            double partner_radius) {
  if (distance <= std::abs(second_radius - first_radius)) return 0.0;
  return std::max(one_side(first_radius, second_radius, distance, partner_radius),
                  one_side(second_radius, first_radius, distance, partner_radius));
}

SurfaceError surface_error_of(std::span<const ElementSphere> spheres) {
  SurfaceError error;
  if (spheres.size() < 2) return error;
  // 1. In order along the line
  Vec3 axis = Vec3::Zero();
  for (const ElementSphere& sphere : spheres) {
    const Vec3 apart = sphere.centre - spheres.front().centre;
    if (apart.squaredNorm() > axis.squaredNorm()) axis = apart;
  }
  std::vector<ElementSphere> row(spheres.begin(), spheres.end());
  std::sort(row.begin(), row.end(), [&](const ElementSphere& a, const ElementSphere& b) {
    return a.centre.dot(axis) < b.centre.dot(axis);
  });
  double smallest = row.front().radius;
  for (const ElementSphere& sphere : row) smallest = std::min(smallest, sphere.radius);
  // 2. Neighbour by neighbour
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    const double first = row[i].radius, second = row[i + 1].radius;
    const double distance = (row[i + 1].centre - row[i].centre).norm();
    if (!(distance > 0.0)) continue;
    const double density = (first + second) / distance;
    if (error.sphere_density == 0.0 || density < error.sphere_density) {
      error.sphere_density = density;
    }
    error.contact_normal =
        std::max(error.contact_normal, contact_normal_error(first, second, distance, smallest));
  }
  error.pseudo_friction = steady_tan(error.contact_normal);
  return error;
}

}  // namespace graintruth::sim
