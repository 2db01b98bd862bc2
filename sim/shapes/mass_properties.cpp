// Volume, centre and inertia of a union of spheres, each point counted once.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/laws/elementary.h"
#include "sim/shapes/clump.h"

namespace graintruth::sim {
namespace {

constexpr double kPi = std::numbers::pi;

// Unit vector along the line on which all centres lie; nothing when they do not.
std::optional<Vec3> common_axis(std::span<const ElementSphere> spheres) {
  const Vec3 origin = spheres.front().centre;
  Vec3 longest = Vec3::Zero();
  double scale = 0.0;
  for (const ElementSphere& sphere : spheres) {
    const Vec3 apart = sphere.centre - origin;
    if (apart.norm() > longest.norm()) longest = apart;
    scale = std::max(scale, sphere.radius);
  }
  if (longest.norm() <= 1e-14 * scale) return Vec3(Vec3::UnitX());
  const Vec3 axis = longest.normalized();
  for (const ElementSphere& sphere : spheres) {
    const Vec3 apart = sphere.centre - origin;
    if ((apart - apart.dot(axis) * axis).norm() > 1e-13 * (scale + longest.norm()))
      return std::nullopt;
  }
  return axis;
}

// Integrals of one piece of the profile, Y2(x) = r^2 - (x - c)^2 for a <= x <= b, as polynomials in
// u = x - c.
struct ProfileIntegrals {
  double area = 0.0;     // int Y2 dx
  double first = 0.0;    // int x Y2 dx
  double second = 0.0;   // int x^2 Y2 dx
  double squared = 0.0;  // int Y2^2 dx
};

void add_piece(double radius, double centre, double a, double b, ProfileIntegrals& sum) {
  const double r2 = radius * radius;
  const auto power = [](double u, int n) {
    double result = 1.0;
    for (int i = 0; i < n; ++i) result *= u;
    return result;
  };
  // moment n: int u^n du
  const auto moment = [&](int n) {
    return (power(b - centre, n + 1) - power(a - centre, n + 1)) / (n + 1);
  };
  const double m0 = r2 * moment(0) - moment(2);  // int Y2
  const double m1 = r2 * moment(1) - moment(3);  // int u Y2
  const double m2 = r2 * moment(2) - moment(4);  // int u^2 Y2
  sum.area += m0;
  sum.first += m1 + centre * m0;
  sum.second += m2 + 2.0 * centre * m1 + centre * centre * m0;
  sum.squared += r2 * r2 * moment(0) - 2.0 * r2 * moment(2) + moment(4);
}

// Spheres on one axis. Union profile Y2(x) = max_s (r_s^2 - (x - c_s)^2, 0), with breaks where two
// spheres meet, x = (r_i^2 - r_j^2 + c_j^2 - c_i^2) / (2 (c_j - c_i)), and
//   V = pi int Y2 dx,  I_axial = pi/2 int Y2^2 dx,  I_transverse = pi int [Y2 (x - x_mean)^2 +
//   Y2^2/4] dx.
MassProperties on_one_axis(std::span<const ElementSphere> spheres, const Vec3& axis) {
  const Vec3 origin = spheres.front().centre;
  std::vector<double> centre, breaks;
  for (const ElementSphere& sphere : spheres) centre.push_back((sphere.centre - origin).dot(axis));
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const double ri = spheres[i].radius;
    breaks.push_back(centre[i] - ri);
    breaks.push_back(centre[i] + ri);
    for (std::size_t j = 0; j < i; ++j) {
      const double rj = spheres[j].radius;
      if (centre[i] == centre[j]) continue;
      breaks.push_back((ri * ri - rj * rj + centre[j] * centre[j] - centre[i] * centre[i]) /
                       (2.0 * (centre[j] - centre[i])));
    }
  }
  std::sort(breaks.begin(), breaks.end());
  ProfileIntegrals sum;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double middle = 0.5 * (breaks[k] + breaks[k + 1]);
    double highest = 0.0;
    int outermost = -1;
    for (std::size_t s = 0; s < spheres.size(); ++s) {
      const double u = middle - centre[s];
      const double y2 = spheres[s].radius * spheres[s].radius - u * u;
      if (y2 > highest) {
        highest = y2;
        outermost = static_cast<int>(s);
      }
    }
    if (outermost < 0) continue;
    add_piece(spheres[outermost].radius, centre[outermost], breaks[k], breaks[k + 1], sum);
  }
  MassProperties result;
  const double mean = sum.first / sum.area;
  const double axial = 0.5 * kPi * sum.squared;
  const double transverse = kPi * (sum.second - mean * mean * sum.area + 0.25 * sum.squared);
  result.volume = kPi * sum.area;
  result.centre = origin + mean * axis;
  result.inertia = transverse * Mat3::Identity() + (axial - transverse) * axis * axis.transpose();
  return result;
}

// Nodes and weights of Gauss-Legendre quadrature on [0, 1], by Newton's method on the Legendre
// polynomial.
struct Quadrature {
  std::vector<double> node, weight;
};

Quadrature gauss_legendre(int count) {
  Quadrature rule;
  for (int i = 0; i < count; ++i) {
    double x = steady_cos(kPi * (i + 0.75) / (count + 0.5));
    double slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p = 1.0, previous = 0.0;
      for (int n = 1; n <= count; ++n) {
        const double next = ((2.0 * n - 1.0) * x * p - (n - 1.0) * previous) / n;
        previous = p;
        p = next;
      }
      slope = count * (x * p - previous) / (x * x - 1.0);
      const double change = p / slope;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    rule.node.push_back(0.5 * (1.0 - x));
    rule.weight.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}

struct Disc {
  double x, y, radius;
};

// int 1, x, y, x^2, y^2, xy over a plane region
using AreaMoments = std::array<double, 6>;

// Moments of a union of discs by Green's theorem along the uncovered arcs, e.g. int x^2 dA = 1/3
// oint x^3 dy.
AreaMoments moments_of_discs(const std::vector<Disc>& discs, const Quadrature& rule) {
  AreaMoments moments{};
  std::vector<double> ends;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const Disc& disc = discs[i];
    ends.assign({0.0, 2.0 * kPi});
    for (std::size_t j = 0; j < discs.size(); ++j) {
      const double dx = discs[j].x - disc.x, dy = discs[j].y - disc.y;
      const double distance = std::hypot(dx, dy);
      if (j == i || distance >= disc.radius + discs[j].radius ||
          distance <= std::abs(disc.radius - discs[j].radius)) {
        continue;
      }
      const double cosine =
          (distance * distance + disc.radius * disc.radius - discs[j].radius * discs[j].radius) /
          (2.0 * distance * disc.radius);
      const double half = steady_acos(std::clamp(cosine, -1.0, 1.0));
      const double direction = steady_atan2(dy, dx);
      for (const double angle : {direction - half, direction + half}) {
        ends.push_back(angle - 2.0 * kPi * std::floor(angle / (2.0 * kPi)));
      }
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      const double middle = 0.5 * (ends[k] + ends[k + 1]);
      const double px = disc.x + disc.radius * steady_cos(middle);
      const double py = disc.y + disc.radius * steady_sin(middle);
      bool covered = false;
      for (std::size_t j = 0; j < discs.size() && !covered; ++j) {
        if (j == i) continue;
        const double gap = std::hypot(px - discs[j].x, py - discs[j].y) - discs[j].radius;
        // Of two equal discs the first one has the boundary
        const bool same =
            discs[j].x == disc.x && discs[j].y == disc.y && discs[j].radius == disc.radius;
        covered = same ? j < i : gap < 0.0;
      }
      if (covered) continue;
      // The integrands are trigonometric polynomials of degree four: the rule is exact on a quarter
      // turn
      const int parts = 1 + static_cast<int>((ends[k + 1] - ends[k]) / (0.5 * kPi));
      const double width = (ends[k + 1] - ends[k]) / parts;
      for (int part = 0; part < parts; ++part) {
        for (std::size_t n = 0; n < rule.node.size(); ++n) {
          const double angle = ends[k] + (part + rule.node[n]) * width;
          const double cosine = steady_cos(angle), sine = steady_sin(angle);
          const double x = disc.x + disc.radius * cosine, y = disc.y + disc.radius * sine;
          const double dy = disc.radius * cosine * width * rule.weight[n];
          const double dx = -disc.radius * sine * width * rule.weight[n];
          moments[0] += 0.5 * (x * dy - y * dx);
          moments[1] += 0.5 * x * x * dy;
          moments[2] -= 0.5 * y * y * dx;
          moments[3] += x * x * x * dy / 3.0;
          moments[4] -= y * y * y * dx / 3.0;
          moments[5] += 0.5 * x * x * y * dy;
        }
      }
    }
  }
  return moments;
}

// Heights at which the shape of a horizontal slice changes its topology: poles of the spheres,
// highest and lowest points of the circles in which two spheres meet, and points in which three
// meet.
std::vector<double> topology_changes(std::span<const ElementSphere> spheres) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Vec3& ci = spheres[i].centre;
    const double ri = spheres[i].radius;
    heights.push_back(ci.z() - ri);
    heights.push_back(ci.z() + ri);
    for (std::size_t j = 0; j < i; ++j) {
      // Circle of i and j: centre ci + h n, radius rho
      const Vec3 apart = spheres[j].centre - ci;
      const double d = apart.norm();
      const double rj = spheres[j].radius;
      if (d == 0.0 || d >= ri + rj || d <= std::abs(ri - rj)) continue;
      const Vec3 n = apart / d;
      const double h = (d * d + ri * ri - rj * rj) / (2.0 * d);
      const double rho = std::sqrt(std::max(ri * ri - h * h, 0.0));
      const Vec3 middle = ci + h * n;
      const double rise = rho * std::sqrt(std::max(1.0 - n.z() * n.z(), 0.0));
      heights.push_back(middle.z() - rise);
      heights.push_back(middle.z() + rise);
      for (std::size_t k = 0; k < j; ++k) {
        // Points p = middle + rho (u cos t + v sin t) on sphere k
        const Vec3 u = n.unitOrthogonal();
        const Vec3 v = n.cross(u);
        const Vec3 to = middle - spheres[k].centre;
        const double a = 2.0 * rho * to.dot(u), b = 2.0 * rho * to.dot(v);
        const double c = spheres[k].radius * spheres[k].radius - to.squaredNorm() - rho * rho;
        const double amplitude = std::hypot(a, b);
        if (amplitude == 0.0 || std::abs(c) > amplitude) continue;
        const double phase = steady_atan2(b, a), half = steady_acos(c / amplitude);
        for (const double t : {phase - half, phase + half}) {
          heights.push_back(middle.z() + rho * (u.z() * steady_cos(t) + v.z() * steady_sin(t)));
        }
      }
    }
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

// What horizontal slices add up to.
struct SliceSum {
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // int x x^T dV

  void add(double weight, double z, const AreaMoments& m) {
    volume += weight * m[0];
    first += weight * Vec3(m[1], m[2], z * m[0]);
    Mat3 slice;
    slice << m[3], m[5], z * m[1], m[5], m[4], z * m[2], z * m[1], z * m[2], z * z * m[0];
    second += weight * slice;
  }
  MassProperties result() const {
    MassProperties properties;
    properties.volume = volume;
    properties.centre = first / volume;
    const Mat3 central = second - volume * properties.centre * properties.centre.transpose();
    properties.inertia = central.trace() * Mat3::Identity() - central;
    return properties;
  }
};

std::vector<Disc> discs_at(std::span<const ElementSphere> spheres, double z) {
  std::vector<Disc> discs;
  for (const ElementSphere& sphere : spheres) {
    const double up = z - sphere.centre.z();
    const double squared = sphere.radius * sphere.radius - up * up;
    if (squared > 0.0) {
      discs.push_back({sphere.centre.x(), sphere.centre.y(), std::sqrt(squared)});
    }
  }
  return discs;
}

// Any arrangement: horizontal slices. The moments of a slice have square-root ends at the topology
// changes; the substitution z = a + (b - a) (1 - cos(pi t))/2 makes them smooth, so that 40 nodes
// are enough for 1e-11.
MassProperties by_slices(std::span<const ElementSphere> spheres) {
  constexpr int kHeightNodes = 40, kArcNodes = 16;
  const Quadrature over_height = gauss_legendre(kHeightNodes);
  const Quadrature along_arc = gauss_legendre(kArcNodes);
  const std::vector<double> heights = topology_changes(spheres);
  const double size = heights.back() - heights.front();
  SliceSum sum;
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    const double a = heights[k], b = heights[k + 1];
    if (b - a <= 1e-14 * size) continue;
    for (int n = 0; n < kHeightNodes; ++n) {
      const double t = over_height.node[n];
      const double z = a + 0.5 * (b - a) * (1.0 - steady_cos(kPi * t));
      const double weight = over_height.weight[n] * 0.5 * (b - a) * kPi * steady_sin(kPi * t);
      const std::vector<Disc> discs = discs_at(spheres, z);
      if (!discs.empty()) sum.add(weight, z, moments_of_discs(discs, along_arc));
    }
  }
  return sum.result();
}

// Many spheres have too many changes of topology to stop at each: slices of equal thickness, twice
// as many until volume and inertia change by less than 1e-6.
MassProperties by_even_slices(std::span<const ElementSphere> spheres) {
  constexpr int kHeightNodes = 4, kArcNodes = 8, kMostSlices = 1024;
  constexpr double kTolerance = 1e-6;
  const Quadrature over_height = gauss_legendre(kHeightNodes);
  const Quadrature along_arc = gauss_legendre(kArcNodes);
  double low = spheres.front().centre.z(), high = low;
  for (const ElementSphere& sphere : spheres) {
    low = std::min(low, sphere.centre.z() - sphere.radius);
    high = std::max(high, sphere.centre.z() + sphere.radius);
  }
  MassProperties before;
  for (int slices = 32;; slices *= 2) {
    SliceSum sum;
    const double thickness = (high - low) / slices;
    for (int k = 0; k < slices; ++k) {
      for (int n = 0; n < kHeightNodes; ++n) {
        const double z = low + (k + over_height.node[n]) * thickness;
        const std::vector<Disc> discs = discs_at(spheres, z);
        if (discs.empty()) continue;
        sum.add(over_height.weight[n] * thickness, z, moments_of_discs(discs, along_arc));
      }
    }
    const MassProperties now = sum.result();
    const bool settled = std::abs(now.volume - before.volume) < kTolerance * now.volume &&
                         (now.inertia - before.inertia).norm() < kTolerance * now.inertia.norm();
    if (settled || slices >= kMostSlices) return now;
    before = now;
  }
}

}  // namespace

MassProperties mass_properties_of_union(std::span<const ElementSphere> spheres) {
  if (const std::optional<Vec3> axis = common_axis(spheres)) return on_one_axis(spheres, *axis);
  constexpr std::size_t kMostForExactSlices = 24;
  return spheres.size() <= kMostForExactSlices ? by_slices(spheres) : by_even_slices(spheres);
}

}  // namespace graintruth::sim
