#include "datasets/store/silhouette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace graintruth::datasets {
namespace {

constexpr double r = 0.002;  // m

std::vector<double> columns(double from, double to, double width) {
  std::vector<double> middles;
  const auto count = static_cast<int>(std::lround((to - from) / width));
  for (int i = 0; i < count; ++i) middles.push_back(from + (i + 0.5) * width);
  return middles;
}

// The mean of sqrt(r^2 - x^2) between two x: the area under a circle over its chord.
double mean_of_circle(double from, double to) {
  const auto area = [](double x) {
    return 0.5 * (x * std::sqrt(r * r - x * x) + r * r * std::asin(x / r));
  };
  return (area(to) - area(from)) / (to - from);
}

TEST(Silhouette, OfNothingIsUnknown) {
  for (const double z : silhouette({}, columns(-0.01, 0.01, r), {})) EXPECT_TRUE(std::isnan(z));
}

TEST(Silhouette, OfOneBallInParallelIsACircle) {
  const Ball ball{{0.0, 0.03, 0.01}, r};
  const double width = 0.25 * r;
  const auto x = columns(-2.0 * r, 2.0 * r, width);
  const auto z = silhouette({&ball, 1}, x, {});
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(x[i]) > r) {
      EXPECT_TRUE(std::isnan(z[i])) << x[i];
    } else {
      const double expected = 0.01 + mean_of_circle(x[i] - 0.5 * width, x[i] + 0.5 * width);
      EXPECT_NEAR(z[i], expected, 1e-3 * 2.0 * r) << x[i];
    }
  }
}

// Straight in front of the eye the shadow is a circle: its half-width is D r / sqrt(d^2 - r^2) for
// a ball d away on the axis, D being how far the plane is.
TEST(Silhouette, OfOneBallInPerspectiveIsLargerTheNearerItIs) {
  const double plane = 0.4, depth = 0.1;
  const Eye eye{.x = 0.01, .z = 0.03, .distance = plane};
  double last = 1.0;
  for (const double y : {-depth, 0.0, depth}) {
    const Ball ball{{eye.x, y, eye.z}, r};
    const double away = plane + y;
    const double radius = plane * r / std::sqrt(away * away - r * r);
    const double narrow = 0.01 * r;
    const std::vector<double> x = {eye.x - narrow, eye.x, eye.x + narrow};
    const auto z = silhouette({&ball, 1}, x, eye);
    EXPECT_NEAR(z[1], eye.z + radius, 1e-4 * r) << y;
    EXPECT_LT(radius, last);
    last = radius;
    // Half-way out it has fallen to sqrt(3)/2 of that
    const std::vector<double> half = {eye.x + 0.5 * radius - narrow, eye.x + 0.5 * radius};
    EXPECT_NEAR(
        silhouette({&ball, 1}, half, eye)[1], eye.z + 0.5 * std::sqrt(3.0) * radius, 1e-4 * r);
  }
}

// Every line of sight to the edge, wherever it is, touches the ball.
TEST(Silhouette, OfOneBallAsideIsTouchedByItsLinesOfSight) {
  const Eye eye{.x = -0.05, .z = 0.08, .distance = 0.3};
  const Ball ball{{0.06, 0.04, 0.01}, 0.012};
  const auto x = columns(0.02, 0.06, 1e-5);
  const auto z = silhouette({&ball, 1}, x, eye);
  const Eigen::Vector3d from(eye.x, -eye.distance, eye.z);
  int seen = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isnan(z[i])) continue;
    const Eigen::Vector3d sight = (Eigen::Vector3d(x[i], 0.0, z[i]) - from).normalized();
    const Eigen::Vector3d to_ball = ball.centre - from;
    EXPECT_NEAR((to_ball - to_ball.dot(sight) * sight).norm(), ball.radius, 1e-3 * ball.radius);
    ++seen;
  }
  EXPECT_GT(seen, 1000);
}

TEST(Silhouette, OfTwoBallsIsTheHigherOne) {
  const std::vector<Ball> balls = {{{0.0, 0.0, 0.01}, r}, {{r, 0.02, 0.01 + r}, r}};
  const double narrow = 0.01 * r;
  for (const double at : {-0.5 * r, 0.25 * r, 0.9 * r, 1.8 * r}) {
    const std::vector<double> x = {at, at + narrow};
    const double first = at < r ? 0.01 + std::sqrt(r * r - at * at) : 0.0;
    const double second = at > 0.0 ? 0.01 + r + std::sqrt(r * r - (at - r) * (at - r)) : 0.0;
    EXPECT_NEAR(silhouette(balls, x, {})[0], std::max(first, second), 1e-3 * r) << at;
  }
}

TEST(Silhouette, GoesOverToParallelFarAway) {
  const std::vector<Ball> balls = {{{0.0, 0.05, 0.01}, r}, {{r, -0.02, 0.01 + r}, r}};
  const auto x = columns(-r, 2.0 * r, r);
  const auto parallel = silhouette(balls, x, {});
  const auto far = silhouette(balls, x, {.distance = 1e5});
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(far[i], parallel[i], 1e-3 * r);
}

TEST(Silhouette, LeavesOutAColumnThatIsHardlyCovered) {
  const Ball ball{{0.0, 0.0, 0.0}, r};
  const std::vector<double> x = {-1.1 * r, 0.9 * r};  // 2 r wide: covered by 45 and 55 %
  const auto z = silhouette({&ball, 1}, x, {});
  EXPECT_TRUE(std::isnan(z[0]));
  EXPECT_FALSE(std::isnan(z[1]));
}

TEST(Silhouette, DoesNotSeeWhatIsBehindTheEye) {
  const Ball ball{{0.0, -0.5, 0.0}, r};
  const std::vector<double> x = {0.0, r};
  EXPECT_TRUE(std::isnan(silhouette({&ball, 1}, x, {.distance = 0.3})[0]));
}

}  // namespace
}  // namespace graintruth::datasets
