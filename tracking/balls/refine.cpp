#include "tracking/balls/refine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

// An edge is this many times the camera's noise.
constexpr double least_edge = 4.0;

// Where an edge crosses a ray.
struct RayHit {
  bool eligible = false;  // the ray looks at this body's own outline and nothing else
  bool found = false;
  bool placed = false;        // its place can be trusted
  double displacement = 0.0;  // px, edge minus expected outline, along the outward normal
  double strength = 0.0;      // gradient over what gradients are just inside the outline
  double variance = 0.0;      // px^2, of the displacement; 0 where no limb was fitted
  Eigen::Vector3d derivative =
      Eigen::Vector3d::Zero();  // of displacement by ball (x, z, radius), px/m
};

double distance_to_segment(const Eigen::Vector2d& point, const datasets::Wall& wall) {
  const Eigen::Vector2d from(wall.from_x, wall.from_z),
      along(wall.to_x - wall.from_x, wall.to_z - wall.from_z);
  const double square = along.squaredNorm();
  const double share =
      square > 0.0 ? std::clamp((point - from).dot(along) / square, 0.0, 1.0) : 0.0;
  return (point - from - share * along).norm();
}

// The strongest change of colour along a ray within the window, preferring where it is expected.
// `outward` is how far out the ray may look before it sees a neighbour, px.
void find_edge(const EdgeImage& image,
               const Eigen::Vector2d& expected,
               const Eigen::Vector2d& normal,
               double window,
               double outward,
               const Eigen::Matrix3f& whitening,
               double noise,
               const LimbModel* limb,
               RayHit& hit,
               RayProfile* seen = nullptr) {
  constexpr double step = 0.5;  // px
  constexpr int most_samples = 64;
  const int half = std::min(static_cast<int>(std::lround(window / step)) + 2, most_samples / 2 - 1);
  std::array<Eigen::Vector3f, most_samples> colours;
  if (!image.contains(expected, half * step + 2.0)) return;
  for (int i = -half; i <= half; ++i) {
    const Eigen::Vector2d pixel = expected + i * step * normal;
    if (image.is_saturated(pixel)) {
      hit.eligible = false;
      return;
    }
    colours[static_cast<std::size_t>(i + half)] = image.at(pixel);
  }
  // Squared gradient over one pixel, all channels together
  std::array<double, most_samples> energy;
  int best = -1;
  double best_score = 0.0;
  for (int i = 1; i < 2 * half; ++i) {
    const auto k = static_cast<std::size_t>(i);
    energy[k] = (whitening * (colours[k + 1] - colours[k - 1])).squaredNorm();
    if (i < 2 || i > 2 * half - 2 || (i - half) * step > outward) continue;
    const double offset = (i - half) * step / window;
    const double score = energy[k] / (1.0 + offset * offset);
    if (score > best_score) {
      best_score = score;
      best = i;
    }
  }
  if (best < 0) return;
  // Climb to the energy's own maximum, then a parabola through it and its neighbours
  const auto energy_at = [&](int i) { return energy[static_cast<std::size_t>(i)]; };
  while (best > 2 && energy_at(best - 1) > energy_at(best)) --best;
  while (best < 2 * half - 2 && energy_at(best + 1) > energy_at(best)) ++best;
  const double before = energy_at(best - 1), here = energy_at(best), after = energy_at(best + 1);
  const double curvature = before - 2.0 * here + after;
  // Still rising at the end of the window, or beyond where a neighbour begins: somebody else's edge
  if (curvature >= 0.0 || before > here || after > here || (best - half) * step > outward) return;
  hit.displacement = ((best - half) + 0.5 * (before - after) / curvature) * step;
  hit.strength = std::sqrt(here);
  const auto k = static_cast<std::size_t>(best);
  hit.found = (colours[k + 1] - colours[k - 1]).norm() > least_edge * noise;
  hit.placed = hit.found;
  if (!hit.found || (limb == nullptr && seen == nullptr)) return;
  RayProfile profile;
  if (!image.contains(expected, RayProfile::inside * step + 2.0)) {
    hit.placed = limb == nullptr;
    return;
  }
  for (int i = -RayProfile::inside; i <= RayProfile::outside; ++i) {
    const auto n = static_cast<std::size_t>(i + RayProfile::inside);
    profile.colours[n] = std::abs(i) <= half ? colours[static_cast<std::size_t>(i + half)]
                                             : image.at(expected + i * step * normal);
  }
  profile.usable =
      std::min(RayProfile::samples, RayProfile::inside + 1 + static_cast<int>(outward / step));
  if (seen != nullptr) *seen = profile;
  if (limb == nullptr) return;
  hit.placed = false;
  const LimbEdge edge = limb->locate(profile, 0.0, window, noise);
  hit.placed = edge.found;
  if (!edge.found) return;
  hit.displacement = edge.position;
  hit.variance = edge.variance;
}

// The limb itself, within `reach` of the expected outline: for poses that are known well enough.
void find_limb(const EdgeImage& image,
               const Eigen::Vector2d& expected,
               const Eigen::Vector2d& normal,
               double outward,
               const LimbModel& limb,
               double reach,
               double noise,
               RayHit& hit) {
  constexpr double step = RayProfile::step;
  if (!image.contains(expected, RayProfile::inside * step + 2.0)) return;
  RayProfile profile;
  profile.usable =
      std::min(RayProfile::samples, RayProfile::inside + 1 + static_cast<int>(outward / step));
  for (int i = 0; i < std::min(profile.usable, RayProfile::samples); ++i) {
    const Eigen::Vector2d pixel = expected + (i - RayProfile::inside) * step * normal;
    if (image.is_saturated(pixel)) return;
    profile.colours[static_cast<std::size_t>(i)] = image.at(pixel);
  }
  const LimbEdge edge = limb.locate(profile, 0.0, reach, noise);
  hit.found = hit.placed = edge.found;
  hit.displacement = edge.position;
  hit.variance = edge.variance;
}

// What gradients are like just inside this body's outline, where there is only shading, gloss and
// noise: the matrix that makes them round and of unit size. An edge then stands out by a change of
// colour that shading does not make (a dark side is a darker shade of the same paint), whatever
// paint and light are. The largest tenth is left out: highlights.
Eigen::Matrix3f whitening_of(const EdgeImage& image,
                             const Camera& camera,
                             const BodyShape& shape,
                             const BodyPose& pose,
                             double noise) {
  constexpr int directions = 24;
  struct Difference {
    Eigen::Vector3f value;
    float square;
  };
  std::vector<Difference> differences;
  Eigen::Vector3f paint = Eigen::Vector3f::Zero();
  const auto centres = ball_centres(pose, shape);
  for (std::size_t ball = 0; ball < shape.balls; ++ball) {
    const double pixel = 1.0 / camera.scale(centres[ball].x(), centres[ball].y());  // m
    const Eigen::Matrix2d pixel_from_plane = camera.jacobian(centres[ball].x(), centres[ball].y());
    const Eigen::Vector2d middle = camera.project(centres[ball].x(), centres[ball].y());
    for (int k = 0; k < directions; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / directions;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      // From well inside to three pixels inside the rim; numerals lie further in.
      for (double reach = 0.72 * shape.radius[ball]; reach < shape.radius[ball] - 3.0 * pixel;
           reach += pixel) {
        const Eigen::Vector2d point = centres[ball] + reach * direction;
        if (shape.balls == 2 &&
            (point - centres[1 - ball]).norm() < shape.radius[1 - ball] + 2.0 * pixel)
          continue;
        const Eigen::Vector2d inner =
            middle + pixel_from_plane * ((reach - 0.5 * pixel) * direction);
        const Eigen::Vector2d outer =
            middle + pixel_from_plane * ((reach + 0.5 * pixel) * direction);
        if (!image.contains(inner, 2.0) || !image.contains(outer, 2.0)) continue;
        if (image.is_saturated(inner) || image.is_saturated(outer)) continue;
        const Eigen::Vector3f value = image.at(outer) - image.at(inner);
        differences.push_back({value, value.squaredNorm()});
        paint += image.at(inner);
      }
    }
  }
  // Compression distorts edges, above all of colour, by a few times what the noise of flat parts
  // tells.
  constexpr double distortion = 3.0;
  Eigen::Matrix3f covariance =
      static_cast<float>(distortion * distortion * noise * noise) * Eigen::Matrix3f::Identity();
  if (differences.size() >= 10) {
    const auto kept = differences.size() - differences.size() / 10;
    std::nth_element(differences.begin(),
                     differences.begin() + static_cast<std::ptrdiff_t>(kept - 1),
                     differences.end(),
                     [](const auto& a, const auto& b) { return a.square < b.square; });
    for (std::size_t i = 0; i < kept; ++i)
      covariance +=
          differences[i].value * differences[i].value.transpose() / static_cast<float>(kept);
  }
  // A shadow's edge on the ball takes away a share of all channels alike; there need not be one
  // within the ring above.
  if (!differences.empty()) {
    constexpr float shadow_share = 0.1F;  // of the light, over a pixel
    paint *= shadow_share / static_cast<float>(differences.size());
    covariance += paint * paint.transpose();
  }
  // |L^-1 g|^2 = g^T covariance^-1 g
  const Eigen::LLT<Eigen::Matrix3f> factor(covariance);
  return factor.matrixL().solve(Eigen::Matrix3f::Identity());
}

using Rays = std::array<std::array<RayHit, rays_per_ball>, 2>;

const std::array<Eigen::Vector2d, rays_per_ball> ray_directions = [] {
  std::array<Eigen::Vector2d, rays_per_ball> directions;
  for (int k = 0; k < rays_per_ball; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / rays_per_ball;
    directions[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
  }
  return directions;
}();

// All rays of a body at a pose.
void cast_rays(const EdgeImage& image,
               const Camera& camera,
               const BodyShape& shape,
               const BodyPose& pose,
               const Surroundings& surroundings,
               const RefineOptions& options,
               const Eigen::Matrix3f& whitening,
               Rays& rays,
               ObservedLimbs* observed = nullptr) {
  const auto centres = ball_centres(pose, shape);
  std::vector<Eigen::Vector2d> outline(rays_per_ball);
  for (std::size_t ball = 0; ball < shape.balls; ++ball) {
    const double radius = shape.radius[ball];
    const Eigen::Matrix2d pixel_from_plane = camera.jacobian(centres[ball].x(), centres[ball].y());
    const double scale = std::sqrt(std::abs(pixel_from_plane.determinant()));
    // Two edges closer than this melt into one: blur of about a pixel on each side, or a twelfth of
    // a radius.
    const double clearance = std::max(2.0 / scale, 0.08 * radius);
    sphere_outline(camera, centres[ball].x(), centres[ball].y(), radius, outline);
    for (int k = 0; k < rays_per_ball; ++k) {
      RayHit& hit = rays[ball][static_cast<std::size_t>(k)];
      hit = RayHit{};
      const Eigen::Vector2d& direction = ray_directions[static_cast<std::size_t>(k)];
      const Eigen::Vector2d point = centres[ball] + radius * direction;
      if (shape.balls == 2 &&
          (point - centres[1 - ball]).norm() < shape.radius[1 - ball] + clearance)
        continue;
      double gap = 1.0e9;  // m, to the nearest foreign edge
      for (const auto& disc : surroundings.discs)
        gap = std::min(gap, (point - disc.centre).norm() - disc.radius);
      for (const auto& wall : surroundings.walls)
        gap = std::min(gap, distance_to_segment(point, wall));
      if (gap < clearance) continue;
      const Eigen::Vector2d& pixel = outline[static_cast<std::size_t>(k)];
      const Eigen::Vector2d& next = outline[static_cast<std::size_t>((k + 1) % rays_per_ball)];
      const Eigen::Vector2d& last =
          outline[static_cast<std::size_t>((k + rays_per_ball - 1) % rays_per_ball)];
      // Counter-clockwise in the plane is clockwise in rows that count downwards.
      const Eigen::Vector2d tangent = (next - last).normalized();
      const Eigen::Vector2d normal(-tangent.y(), tangent.x());
      hit.eligible = image.contains(pixel, options.window_px + 4.0);
      if (!hit.eligible) continue;
      const Eigen::Vector2d moved = pixel_from_plane.transpose() * normal;
      hit.derivative << moved.x(), moved.y(), moved.dot(direction);
      // A foreign edge reaches about a pixel and a half towards us by blur.
      const double outward = gap * scale - 1.5;
      if (options.limb_reach_px > 0.0) {
        find_limb(image,
                  pixel,
                  normal,
                  outward,
                  *options.limb,
                  options.limb_reach_px,
                  options.noise,
                  hit);
        continue;
      }
      RayProfile profile;
      find_edge(image,
                pixel,
                normal,
                options.window_px,
                outward,
                whitening,
                options.noise,
                options.limb,
                hit,
                observed != nullptr ? &profile : nullptr);
      if (observed == nullptr || !hit.placed) continue;
      observed->profiles.push_back(profile);
      observed->edges.push_back(hit.displacement);
    }
  }
}

}  // namespace

double ray_variance(const std::array<double, 4>& autocovariance,
                    const std::array<double, 4>& pairs) {
  const double variance = pairs[0] > 0.0 ? autocovariance[0] / pairs[0] : 0.1;
  double inflation = 1.0;
  for (std::size_t lag = 1; lag < 4; ++lag) {
    if (pairs[lag] > 0.0)
      inflation += 2.0 * std::max(0.0, autocovariance[lag] / pairs[lag] / variance);
  }
  return variance * inflation;
}

BodyFit refine_body(const EdgeImage& image,
                    const Camera& camera,
                    const BodyShape& shape,
                    const BodyPose& start,
                    const Surroundings& surroundings,
                    const RefineOptions& options) {
  BodyFit fit;
  fit.pose = start;
  Rays rays;
  // Lever of each ball's centre about the tracked point, along the axis
  const std::array<double, 2> lever = {-shape.first_share * shape.separation,
                                       (1.0 - shape.first_share) * shape.separation};
  const Eigen::Matrix3f whitening = whitening_of(image, camera, shape, start, options.noise);
  for (int iteration = 0; iteration <= options.iterations; ++iteration) {
    // 1. Edges at the present pose
    cast_rays(image, camera, shape, fit.pose, surroundings, options, whitening, rays);
    std::vector<double> strengths, misses, displacements;
    int eligible = 0;
    for (const auto& ball : rays) {
      for (const RayHit& hit : ball) {
        eligible += hit.eligible;
        if (!hit.found) continue;
        strengths.push_back(hit.strength);
        if (hit.placed) displacements.push_back(hit.displacement);
      }
    }
    fit.visible = static_cast<double>(eligible) / static_cast<double>(shape.balls * rays_per_ball);
    fit.edge_strength = median(std::move(strengths));
    for (double d : displacements) misses.push_back(std::abs(d));
    constexpr double normal_quartile = 0.6745;
    fit.scatter_px = std::max(0.08, median(std::move(misses)) / normal_quartile);

    // 2. Geman-McClure weights about the present pose; weak edges count less
    const double accept = 2.5 * fit.scatter_px;
    const auto weight_of = [&](const RayHit& hit) {
      const double relative = hit.displacement / accept;
      const double robust = 1.0 / std::pow(1.0 + relative * relative, 2);
      if (options.limb != nullptr)
        return robust * fit.scatter_px * fit.scatter_px /
               (fit.scatter_px * fit.scatter_px + hit.variance);
      const double square = hit.strength * hit.strength;
      constexpr double weak = 4.0;  // whitened: twice what lies inside the outline
      return robust * square / (square + weak);
    };
    std::array<BallEvidence, 2> evidence;
    const auto centres = ball_centres(fit.pose, shape);
    int near = 0;
    for (std::size_t ball = 0; ball < shape.balls; ++ball) {
      evidence[ball].reference << centres[ball].x(), centres[ball].y(), shape.radius[ball];
      for (const RayHit& hit : rays[ball]) {
        if (!hit.found) continue;
        near += std::abs(hit.displacement) < std::max(1.0, 0.5 * options.window_px);
        if (!hit.placed) continue;
        const double weight = weight_of(hit);
        evidence[ball].information += weight * hit.derivative * hit.derivative.transpose();
        evidence[ball].gain += weight * hit.displacement * hit.derivative;
      }
    }
    fit.support = eligible > 0 ? static_cast<double>(near) / eligible : 0.0;
    fit.balls = evidence;
    if (iteration == options.iterations) break;

    // 3. One Gauss-Newton step of the rigid body
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    const Eigen::Vector2d across(-std::sin(fit.pose.angle), std::cos(fit.pose.angle));
    for (std::size_t ball = 0; ball < shape.balls; ++ball) {
      Eigen::Matrix<double, 2, 3> motion;
      motion << 1.0, 0.0, lever[ball] * across.x(), 0.0, 1.0, lever[ball] * across.y();
      normal += motion.transpose() * evidence[ball].information.topLeftCorner<2, 2>() * motion;
      right += motion.transpose() * evidence[ball].gain.head<2>();
    }
    if (options.known) {
      const Eigen::Matrix3d known = options.ray_variance * options.known->information;
      const BodyPose& pose = options.known->pose;
      normal += known;
      right += known *
               Eigen::Vector3d(pose.x - fit.pose.x,
                               pose.z - fit.pose.z,
                               std::remainder(pose.angle - fit.pose.angle, 2.0 * std::numbers::pi));
    }
    // Held where nothing was seen: as if one ray in each direction said "stay".
    const double scale = camera.scale(fit.pose.x, fit.pose.z);
    normal(0, 0) += 0.1 * scale * scale;
    normal(1, 1) += 0.1 * scale * scale;
    const double lever_arm = shape.shows_angle() ? shape.separation : shape.radius[0];
    normal(2, 2) += 0.1 * std::pow(scale * lever_arm, 2);
    Eigen::Vector3d change = normal.ldlt().solve(right);
    const double largest = options.window_px / scale;
    const double shift = change.head<2>().norm();
    if (shift > largest) change *= largest / shift;
    const double largest_turn = largest / (0.5 * lever_arm);
    if (std::abs(change[2]) > largest_turn) change *= largest_turn / std::abs(change[2]);
    fit.pose.x += change[0];
    fit.pose.z += change[1];
    fit.pose.angle += change[2];
  }

  // 4. How alike neighbouring rays err, which tells how much less than n independent rays they are
  // worth
  for (const auto& ball : rays) {
    for (std::size_t lag = 0; lag < fit.autocovariance.size(); ++lag) {
      for (std::size_t k = 0; k < rays_per_ball; ++k) {
        const RayHit& one = ball[k];
        const RayHit& other = ball[(k + lag) % rays_per_ball];
        const double limit = 3.0 * fit.scatter_px;
        if (!one.placed || !other.placed || std::abs(one.displacement) > limit ||
            std::abs(other.displacement) > limit)
          continue;
        fit.autocovariance[lag] += one.displacement * other.displacement;
        ++fit.pairs[lag];
      }
    }
  }
  // 5. Colour, over a ring that leaves out the numerals in the middle and the dark rim
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int samples = 0;
  const auto centres = ball_centres(fit.pose, shape);
  for (std::size_t ball = 0; ball < shape.balls; ++ball) {
    const Eigen::Vector2d& centre = centres[ball];
    for (int k = 0; k < 12; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / 12.0;
      const double reach = 0.65 * shape.radius[0];
      const Eigen::Vector2d pixel = camera.project(centre.x() + reach * std::cos(angle),
                                                   centre.y() + reach * std::sin(angle));
      if (!image.contains(pixel, 1.0)) continue;
      sum += image.at(pixel);
      ++samples;
    }
  }
  if (samples > 0) fit.colour = sum / static_cast<float>(samples);
  return fit;
}

std::vector<SeenRay> measure_limb(const EdgeImage& image,
                                  const Camera& camera,
                                  const BodyShape& shape,
                                  const BodyPose& pose,
                                  const Surroundings& surroundings,
                                  const LimbModel& limb,
                                  double reach,
                                  double noise) {
  Rays rays;
  const RefineOptions options{
      .window_px = reach, .noise = noise, .limb = &limb, .limb_reach_px = reach};
  cast_rays(image, camera, shape, pose, surroundings, options, Eigen::Matrix3f::Identity(), rays);
  std::vector<SeenRay> seen;
  for (std::size_t ball = 0; ball < shape.balls; ++ball) {
    for (int k = 0; k < rays_per_ball; ++k) {
      const RayHit& hit = rays[ball][static_cast<std::size_t>(k)];
      if (hit.placed)
        seen.push_back({static_cast<int>(ball), k, hit.displacement, hit.variance, hit.derivative});
    }
  }
  return seen;
}

void observe_limbs(const EdgeImage& image,
                   const Camera& camera,
                   const BodyShape& shape,
                   const BodyPose& pose,
                   const Surroundings& surroundings,
                   const RefineOptions& options,
                   ObservedLimbs& observed) {
  Rays rays;
  const Eigen::Matrix3f whitening = whitening_of(image, camera, shape, pose, options.noise);
  cast_rays(image, camera, shape, pose, surroundings, options, whitening, rays, &observed);
}

}  // namespace graintruth::tracking
