#include "tracking/balls/learn.h"

#include <algorithm>
#include <cmath>

namespace graintruth::tracking {

namespace {

// Weighted median-like mean: values further than three robust deviations from the median do not
// count.
double robust_mean(const std::vector<double>& values, const std::vector<double>& weights) {
  if (values.empty()) return 0.0;
  std::vector<double> sorted = values;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double centre = *middle;
  for (double& v : sorted) v = std::abs(v - centre);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = 3.0 * *middle / 0.6745;
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i] - centre) > limit) continue;
    sum += weights[i] * values[i];
    total += weights[i];
  }
  return total > 0.0 ? sum / total : centre;
}

double spread_of(const std::vector<double>& values, double mean) {
  double square = 0.0;
  for (double v : values) square += (v - mean) * (v - mean);
  return values.size() > 1 ? std::sqrt(square / static_cast<double>(values.size() - 1)) : 0.0;
}

// Scatter of values that should all be `mean` over what their weights (information per ray
// variance) make of it; at least `least`.
double excess_of(const std::vector<double>& values,
                 const std::vector<double>& weights,
                 double mean,
                 double ray_variance,
                 double least) {
  double square_sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double square = std::pow(values[i] - mean, 2) * weights[i] / ray_variance;
    square_sum += std::min(square, 25.0) / static_cast<double>(values.size());
  }
  return values.empty() ? 1.0 : std::max(least, std::sqrt(square_sum));
}

// The ball's centre and its covariance (per ray variance) when its radius is known.
struct CentreEstimate {
  Eigen::Vector2d centre;
  Eigen::Matrix2d information;
};

CentreEstimate centre_at(const BallEvidence& ball, double radius) {
  // Normal equations with the radius moved to the right side
  const Eigen::Matrix2d information = ball.information.topLeftCorner<2, 2>();
  const Eigen::Vector2d gain =
      ball.gain.head<2>() - ball.information.block<2, 1>(0, 2) * (radius - ball.reference[2]);
  return {ball.reference.head<2>() + information.ldlt().solve(gain), information};
}

bool is_well_seen(const BallEvidence& ball) {
  const Eigen::Matrix2d information = ball.information.topLeftCorner<2, 2>();
  const double trace = information.trace();
  return trace > 0.0 && information.determinant() > 0.02 * trace * trace;
}

}  // namespace

Learned learn_shapes(const std::vector<std::vector<BodyFit>>& fits, const BodyShape& nominal) {
  Learned learned;
  std::vector<double> radii, separations;
  for (const std::vector<BodyFit>& frames : fits) {
    LearnedShape body;
    body.shape = nominal;
    // 1. One ray's variance, and how many neighbours share its error
    std::array<double, 4> covariance = {};
    std::array<double, 4> pairs = {};
    for (const BodyFit& fit : frames) {
      for (std::size_t lag = 0; lag < 4; ++lag) {
        covariance[lag] += fit.autocovariance[lag];
        pairs[lag] += fit.pairs[lag];
      }
    }
    body.ray_variance_px2 = ray_variance(covariance, pairs);

    // 2. Radii: information about the radius left when the centre is free
    for (std::size_t ball = 0; ball < nominal.balls; ++ball) {
      std::vector<double> values, weights;
      for (const BodyFit& fit : frames) {
        const BallEvidence& seen = fit.balls[ball];
        if (!is_well_seen(seen)) continue;
        const Eigen::Vector3d change = seen.information.ldlt().solve(seen.gain);
        const double weight =
            seen.information(2, 2) -
            seen.information.block<1, 2>(2, 0).dot(seen.information.topLeftCorner<2, 2>()
                                                       .ldlt()
                                                       .solve(seen.information.block<2, 1>(0, 2))
                                                       .transpose());
        if (!change.allFinite() || !(weight > 0.0)) continue;
        values.push_back(seen.reference[2] + change[2]);
        weights.push_back(weight);
      }
      if (!values.empty()) body.shape.radius[ball] = robust_mean(values, weights);
      radii.push_back(body.shape.radius[ball]);
      // Light and shade that stay on a ball make its radius no less steady: no more is believed
      // than drawn films, whose truth is known, allow.
      constexpr double least_of_radius = 0.6;
      if (nominal.balls == 1) {
        body.excess = excess_of(
            values, weights, body.shape.radius[0], body.ray_variance_px2, least_of_radius);
      }
    }
    if (nominal.balls == 1) {
      body.shape.radius[1] = body.shape.radius[0];
      learned.bodies.push_back(body);
      continue;
    }

    // 3. Separation, with these radii
    std::vector<double> values, weights;
    for (const BodyFit& fit : frames) {
      if (!is_well_seen(fit.balls[0]) || !is_well_seen(fit.balls[1])) continue;
      const CentreEstimate a = centre_at(fit.balls[0], body.shape.radius[0]);
      const CentreEstimate b = centre_at(fit.balls[1], body.shape.radius[1]);
      const Eigen::Vector2d axis = (b.centre - a.centre).normalized();
      const double along = axis.dot((a.information.inverse() + b.information.inverse()) * axis);
      values.push_back((b.centre - a.centre).norm());
      weights.push_back(1.0 / along);
    }
    if (!values.empty()) body.shape.separation = robust_mean(values, weights);
    separations.push_back(body.shape.separation);
    // Rays that err alike on both balls cancel in the separation: what it gains is not believed in
    // full.
    constexpr double least_of_separation = 0.75;
    body.excess = excess_of(
        values, weights, body.shape.separation, body.ray_variance_px2, least_of_separation);
    learned.bodies.push_back(body);
  }
  for (double r : radii) learned.radius_mean += r / static_cast<double>(radii.size());
  for (double d : separations)
    learned.separation_mean += d / static_cast<double>(separations.size());
  learned.radius_spread = spread_of(radii, learned.radius_mean);
  double difference_square = 0.0;
  for (const LearnedShape& body : learned.bodies) {
    const double difference =
        (body.shape.radius[1] - body.shape.radius[0]) - (nominal.radius[1] - nominal.radius[0]);
    difference_square += difference * difference / static_cast<double>(learned.bodies.size());
  }
  for (LearnedShape& body : learned.bodies) body.radius_difference = std::sqrt(difference_square);
  learned.separation_spread = spread_of(separations, learned.separation_mean);
  return learned;
}

SolvedPose solve_pose(const BodyFit& fit, const LearnedShape& learned) {
  SolvedPose result;
  result.pose = fit.pose;
  const BodyShape& shape = learned.shape;
  const std::array<double, 2> lever = {-shape.first_share * shape.separation,
                                       (1.0 - shape.first_share) * shape.separation};
  Eigen::Matrix3d normal;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const auto centres = ball_centres(result.pose, shape);
    const Eigen::Vector2d across(-std::sin(result.pose.angle), std::cos(result.pose.angle));
    normal.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t ball = 0; ball < shape.balls; ++ball) {
      const BallEvidence& seen = fit.balls[ball];
      const Eigen::Vector3d here(centres[ball].x(), centres[ball].y(), shape.radius[ball]);
      const Eigen::Vector3d pull = seen.gain - seen.information * (here - seen.reference);
      Eigen::Matrix<double, 2, 3> motion;
      motion << 1.0, 0.0, lever[ball] * across.x(), 0.0, 1.0, lever[ball] * across.y();
      normal += motion.transpose() * seen.information.topLeftCorner<2, 2>() * motion;
      right += motion.transpose() * pull.head<2>();
    }
    if (!shape.shows_angle()) normal(2, 2) = 1.0;
    const Eigen::Vector3d change = normal.ldlt().solve(right);
    if (!change.allFinite()) break;
    result.pose.x += change[0];
    result.pose.z += change[1];
    result.pose.angle += change[2];
  }
  result.covariance = normal.inverse() * learned.ray_variance_px2 * learned.excess * learned.excess;
  return result;
}

}  // namespace graintruth::tracking
