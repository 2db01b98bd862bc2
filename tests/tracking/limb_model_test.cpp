// Where a ball ends along a ray, against balls whose edge is known.
#include "tracking/balls/limb_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace graintruth::tracking {
namespace {

// A ray over a ball of `radius` px that ends at `edge`: brightness `rim` at the outline and `rise`
// more where the ball faces the camera, on `background`, blurred by a Gaussian (summed, not taken
// from the model's tables).
RayProfile draw_ray(
    double radius, double edge, double rim, double rise, double background, double blur) {
  RayProfile profile;
  constexpr int parts = 400;
  constexpr double reach = 5.0;  // blurs
  for (int i = 0; i < RayProfile::samples; ++i) {
    const double t = (i - RayProfile::inside) * RayProfile::step;
    double sum = 0.0, weights = 0.0;
    for (int k = 0; k <= parts; ++k) {
      const double offset = blur * reach * (2.0 * k / parts - 1.0);
      const double weight = std::exp(-0.5 * offset * offset / (blur * blur));
      const double share = 1.0 + (t + offset - edge) / radius;  // of the radius
      const double here = share < 1.0 ? rim + rise * std::sqrt(1.0 - share * share) : background;
      sum += weight * here;
      weights += weight;
    }
    profile.colours[static_cast<std::size_t>(i)] =
        Eigen::Vector3f(static_cast<float>(sum / weights), 0.0F, 0.0F);
  }
  return profile;
}

// Where the picture changes most, which is what the limb model is better than.
double steepest(const RayProfile& profile) {
  int best = 1;
  const auto slope = [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    return std::abs(profile.colours[k + 1][0] - profile.colours[k - 1][0]);
  };
  for (int i = 2; i + 1 < RayProfile::samples; ++i)
    if (slope(i) > slope(best)) best = i;
  return (best - RayProfile::inside) * RayProfile::step;
}

TEST(LimbModel, FindsTheEdgeOfAFlatDisc) {
  const LimbModel model(24.0, 1.2, 1.9);
  for (double edge : {-0.8, -0.31, 0.0, 0.4, 0.9}) {
    const LimbEdge found = model.locate(draw_ray(24.0, edge, 140, 0, 80, 1.2), 0.0, 1.25, 1.0);
    ASSERT_TRUE(found.found);
    EXPECT_NEAR(found.position, edge, 0.02);
  }
}

TEST(LimbModel, IsNotDrawnInwardsByShading) {
  for (double radius : {14.0, 24.0, 60.0}) {
    const LimbModel model(radius, 1.2, 1.9);
    // A rim nearly as bright as what lies behind: the shading is all that changes much.
    const RayProfile profile = draw_ray(radius, 0.0, 100, 120, 80, 1.2);
    EXPECT_LT(steepest(profile), -0.4) << "an easy ray: nothing to be better than";
    const LimbEdge found = model.locate(profile, steepest(profile), 1.5, 1.0);
    ASSERT_TRUE(found.found);
    EXPECT_NEAR(found.position, 0.0, 0.05) << radius;
  }
}

// An orange ball before grey of the same brightness, whose limb is at `edge`. Light on it is
// stronger by `more` inside of the place `shadow`, in grey levels. Places in px.
RayProfile orange_before_grey(double edge, double more, double shadow) {
  const Eigen::Vector3f paint(1.0F, 0.5F, -0.6F), ground(90.0F, 0.0F, 0.0F);
  RayProfile profile;
  for (int i = 0; i < RayProfile::samples; ++i) {
    const double t = (i - RayProfile::inside) * RayProfile::step;
    const auto inside = [&](double blur) {
      return static_cast<float>(0.5 * std::erfc((t - edge) / (blur * std::numbers::sqrt2)));
    };
    const auto light = static_cast<float>(
        90.0 + 0.5 * more * std::erfc((t - shadow) / (1.2 * std::numbers::sqrt2)));
    Eigen::Vector3f& colour = profile.colours[static_cast<std::size_t>(i)];
    colour = inside(1.9) * light * paint + (1.0F - inside(1.9)) * ground;
    colour[0] = inside(1.2) * light * paint[0] + (1.0F - inside(1.2)) * ground[0];
  }
  return profile;
}

TEST(LimbModel, IsSeenByItsHueWhereBallAndGroundAreEquallyBright) {
  for (const double edge : {-0.6, 0.0, 0.3}) {
    const LimbEdge found =
        LimbModel(24.0, 1.2, 1.9).locate(orange_before_grey(edge, 0.0, -3.0), 0.0, 2.75, 1.0);
    ASSERT_TRUE(found.found);
    EXPECT_NEAR(found.position, edge, 0.2);
  }
}

// A hard shadow is no part of the model and draws the limb a little inwards, but it is not taken
// for the limb.
TEST(LimbModel, IsNotWhereAShadowEnds) {
  constexpr double edge = 0.3, shadow = -3.0;
  const LimbEdge found =
      LimbModel(24.0, 1.2, 1.9).locate(orange_before_grey(edge, 80.0, shadow), 0.0, 2.75, 1.0);
  ASSERT_TRUE(found.found);
  EXPECT_LT(std::abs(found.position - edge), 0.25 * (edge - shadow));
}

TEST(LimbModel, IsLessSureWhereTheEdgeIsFaint) {
  const LimbModel model(24.0, 1.2, 1.9);
  const LimbEdge plain = model.locate(draw_ray(24.0, 0.0, 160, 40, 80, 1.2), 0.0, 1.25, 2.0);
  const LimbEdge faint = model.locate(draw_ray(24.0, 0.0, 95, 40, 80, 1.2), 0.0, 1.25, 2.0);
  ASSERT_TRUE(plain.found && faint.found);
  EXPECT_GT(faint.variance, 4.0 * plain.variance);
}

TEST(LimbModel, VarianceIsThatOfRepeatedNoise) {
  // White noise: every sample is independent, so the stated variance, which allows for smoothing,
  // must be above the true one but not by much.
  const LimbModel model(24.0, 1.2, 1.9);
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0F, 2.0F);
  double square = 0.0, stated = 0.0;
  int found = 0;
  for (int repeat = 0; repeat < 400; ++repeat) {
    RayProfile profile = draw_ray(24.0, 0.2, 130, 30, 80, 1.2);
    for (auto& colour : profile.colours)
      for (int c = 0; c < 3; ++c) colour[c] += noise(random);
    const LimbEdge edge = model.locate(profile, 0.2, 1.25, 2.0);
    if (!edge.found) continue;
    ++found;
    square += std::pow(edge.position - 0.2, 2);
    stated += edge.variance;
  }
  ASSERT_GT(found, 350);
  EXPECT_GT(stated / square, 1.0);
  EXPECT_LT(stated / square, 12.0);
}

TEST(LimbModel, LeavesOutWhatANeighbourHides) {
  RayProfile profile = draw_ray(24.0, 0.3, 140, 20, 80, 1.2);
  profile.usable = RayProfile::inside + 1 + 4;
  for (int i = profile.usable; i < RayProfile::samples; ++i)
    profile.colours[static_cast<std::size_t>(i)] = Eigen::Vector3f(250.0F, 0.0F, 0.0F);
  const LimbEdge found = LimbModel(24.0, 1.2, 1.9).locate(profile, 0.0, 1.25, 1.0);
  ASSERT_TRUE(found.found);
  EXPECT_NEAR(found.position, 0.3, 0.1);
  profile.usable = RayProfile::inside + 1;  // nothing of the background is seen
  EXPECT_FALSE(LimbModel(24.0, 1.2, 1.9).locate(profile, 0.0, 1.25, 1.0).found);
}

TEST(LimbModel, LearnsTheBlurOfAFilm) {
  for (double blur : {1.0, 1.6}) {
    std::vector<RayProfile> profiles;
    std::vector<double> starts;
    for (int i = 0; i < 60; ++i) {
      const double edge = 0.02 * (i - 30);
      profiles.push_back(draw_ray(24.0, edge, 90 + i, 30 + 0.5 * i, 60, blur));
      starts.push_back(0.0);
    }
    EXPECT_NEAR(learn_limb_model(24.0, profiles, starts).brightness_blur_px(), blur, 0.11);
  }
}

}  // namespace
}  // namespace graintruth::tracking
