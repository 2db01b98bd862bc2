#include "tracking/balls/bodies.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graintruth::tracking {

namespace {
// An outline hidden more than this is no evidence.
constexpr double least_visible = 0.10;

}  // namespace

std::vector<BodyPose> possible_poses(const BodyShape& shape,
                                     const std::vector<BallCandidate>& candidates,
                                     double tolerance) {
  std::vector<BodyPose> poses;
  if (shape.balls == 1) {
    for (const BallCandidate& candidate : candidates)
      poses.push_back({candidate.x, candidate.z, 0.0});
    return poses;
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2d a(candidates[i].x, candidates[i].z),
          b(candidates[j].x, candidates[j].z);
      if (std::abs((b - a).norm() / shape.separation - 1.0) > tolerance) continue;
      const Eigen::Vector2d point = a + shape.first_share * (b - a);
      poses.push_back({point.x(), point.y(), std::atan2(b.y() - a.y(), b.x() - a.x())});
    }
  }
  return poses;
}

std::vector<BodyFit> fit_bodies(const EdgeImage& image,
                                const Camera& camera,
                                const BodyShape& shape,
                                const std::vector<BodyPose>& poses,
                                const Surroundings& surroundings,
                                double noise,
                                double least_support) {
  std::vector<BodyFit> fits;
  for (const BodyPose& pose : poses) {
    const double radius_px = camera.scale(pose.x, pose.z) * shape.radius[0];
    BodyFit fit = refine_body(
        image,
        camera,
        shape,
        pose,
        surroundings,
        {.window_px = std::max(3.0, 0.16 * radius_px), .iterations = 3, .noise = noise});
    if (fit.support < least_support || fit.visible < least_visible) continue;
    fits.push_back(refine_body(
        image,
        camera,
        shape,
        fit.pose,
        surroundings,
        {.window_px = std::max(2.0, 0.08 * radius_px), .iterations = 2, .noise = noise}));
  }
  std::erase_if(fits, [&](const BodyFit& fit) { return fit.support < least_support; });
  return fits;
}

double evidence_of(const BodyFit& fit) {
  // Rays that miss count against; strong edges beat the faint ones of shadows, but only slowly.
  return (fit.support - 0.4) * std::sqrt(fit.visible) * std::log1p(fit.edge_strength);
}

std::vector<BodyFit> choose_bodies(const std::vector<BodyFit>& fits,
                                   const BodyShape& shape,
                                   std::size_t count) {
  std::vector<std::size_t> order(fits.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return evidence_of(fits[a]) > evidence_of(fits[b]);
  });
  const auto conflicts = [&](std::size_t a, std::size_t b) {
    return overlap(fits[a].pose, fits[b].pose, shape);
  };
  // Fills free places greedily.
  const auto fill = [&](std::vector<std::size_t>& chosen) {
    for (std::size_t candidate : order) {
      if (chosen.size() >= count) break;
      if (std::none_of(
              chosen.begin(), chosen.end(), [&](std::size_t c) { return conflicts(c, candidate); }))
        chosen.push_back(candidate);
    }
  };
  const auto total = [&](const std::vector<std::size_t>& chosen) {
    double sum = 0.0;
    for (std::size_t c : chosen) sum += evidence_of(fits[c]);
    return sum;
  };
  std::vector<std::size_t> chosen;
  fill(chosen);
  // Force each unused candidate in, throw out what it hits, fill again; keep what is better.
  bool improved = true;
  for (int round = 0; improved && round < 20; ++round) {
    improved = false;
    for (std::size_t candidate : order) {
      if (std::find(chosen.begin(), chosen.end(), candidate) != chosen.end()) continue;
      std::vector<std::size_t> trial = {candidate};
      for (std::size_t c : chosen)
        if (!conflicts(c, candidate) && trial.size() < count) trial.push_back(c);
      fill(trial);
      if (total(trial) > total(chosen) + 1.0e-9) {
        chosen = trial;
        improved = true;
      }
    }
  }
  std::vector<BodyFit> bodies;
  for (std::size_t c : chosen) bodies.push_back(fits[c]);
  return bodies;
}

}  // namespace graintruth::tracking
