#include "calibrate/flow/kinematic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace graintruth::calibrate {
namespace {

std::vector<VelocitySample> profile(
    const KinematicOptions& options, double B, double v0, double noise, std::mt19937& random) {
  std::normal_distribution<double> error(0.0, noise);
  std::vector<VelocitySample> samples;
  for (int i = -6; i <= 6; ++i) {
    const double x = 0.0115 * i;  // 15 cm bin
    samples.push_back(
        {x, kinematic_velocity(options, B, v0, x) + (noise > 0.0 ? error(random) : 0.0), 0.0});
  }
  return samples;
}

TEST(Kinematic, FiniteOrificeTendsToThePoint) {
  const KinematicOptions point{.height = 0.09};
  const KinematicOptions narrow{.height = 0.09, .orifice = 1e-4};
  // Same flux: v0 D = v_axis sqrt(4 pi B h)
  const double B = 0.012;
  const double axis = 1e-4 / std::sqrt(4.0 * M_PI * B * 0.09);
  for (double x : {0.0, 0.02, 0.05})
    EXPECT_NEAR(
        kinematic_velocity(narrow, B, 1.0, x), kinematic_velocity(point, B, axis, x), 1e-6 * axis);
}

TEST(Kinematic, FluxThroughEveryHeightIsThatOfTheOrifice) {
  for (double height : {0.03, 0.09, 0.3}) {
    const KinematicOptions options{.height = height, .orifice = 0.075};
    double flux = 0.0;
    constexpr double stride = 1e-4;
    for (double x = -1.0; x < 1.0; x += stride)
      flux += stride * kinematic_velocity(options, 0.012, 0.4, x);
    EXPECT_NEAR(flux, 0.4 * 0.075, 1e-6);
  }
}

TEST(Kinematic, ExactProfilesGiveTheirB) {
  std::mt19937 random(1);
  for (const KinematicOptions& options :
       {KinematicOptions{.height = 0.09}, KinematicOptions{.height = 0.09, .orifice = 0.075}}) {
    for (double B : {0.004, 0.012, 0.04}) {
      const KinematicFit fit = fit_kinematic(profile(options, B, 0.5, 0.0, random), options);
      EXPECT_NEAR(fit.B, B, 1e-5 * B);
      EXPECT_NEAR(fit.velocity, 0.5, 1e-5);
    }
  }
}

// Within 2 % with noise, and intervals that hold the truth in 93 to 97 % of 1000 repeats.
TEST(Kinematic, RecoversBWithCoverage) {
  for (const KinematicOptions& options :
       {KinematicOptions{.height = 0.09}, KinematicOptions{.height = 0.09, .orifice = 0.075}}) {
    std::mt19937 random(5);
    constexpr double B = 0.012;
    double mean = 0.0;
    int covered = 0;
    constexpr int repeats = 1000;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      const KinematicFit fit = fit_kinematic(profile(options, B, 0.5, 0.01, random), options);
      mean += fit.B / repeats;
      covered += fit.lower < B && B < fit.upper;
    }
    EXPECT_NEAR(mean, B, 0.02 * B);
    EXPECT_GE(covered, 930);
    EXPECT_LE(covered, 970);
  }
}

TEST(Kinematic, PinnedVelocityIsTheThesissForm) {
  std::mt19937 random(1);
  const KinematicOptions shape{.height = 0.09};
  const KinematicOptions pinned{.height = 0.09, .pinned_velocity = 0.45};
  // The centre reads low: a pinned v0 makes the profile look wider than it is.
  const auto samples = profile(shape, 0.012, 0.5, 0.0, random);
  const KinematicFit fit = fit_kinematic(samples, pinned);
  EXPECT_EQ(fit.velocity, 0.45);
  EXPECT_GT(fit.B, 0.012);
  EXPECT_GT(fit.rms, 0.0);
}

TEST(Kinematic, IntervalIsOpenWhereTheProfileIsFlat) {
  std::vector<VelocitySample> samples;
  for (int i = -3; i <= 3; ++i) samples.push_back({0.01 * i, 0.3 + 0.01 * (i % 2), 0.0});
  const KinematicFit fit = fit_kinematic(samples, {.height = 0.09});
  EXPECT_TRUE(std::isinf(fit.upper));
  EXPECT_GT(fit.lower, 0.0);
}

TEST(Kinematic, SaysWhereNoBFits) {
  const KinematicOptions options{.height = 0.09, .orifice = 0.05};
  std::mt19937 random(1);
  EXPECT_TRUE(fit_kinematic(profile(options, 0.012, 0.4, 0.0, random), options).converged);
  std::vector<VelocitySample> flat, needle;
  for (int i = -6; i <= 6; ++i) {
    flat.push_back({0.0115 * i, 0.1, 0.0});
    needle.push_back({0.0115 * i, std::abs(i) <= 2 ? 0.1 : 0.0, 0.0});
  }
  EXPECT_FALSE(fit_kinematic(flat, options).converged);
  EXPECT_TRUE(fit_kinematic(flat, options).is_too_flat);
  EXPECT_FALSE(fit_kinematic(needle, options).converged);
  EXPECT_FALSE(fit_kinematic(needle, options).is_too_flat);
}

TEST(Kinematic, UncertaintiesAreOfAllOrOfNone) {
  const KinematicOptions options{.height = 0.09, .orifice = 0.05};
  std::mt19937 random(1);
  std::vector<VelocitySample> samples = profile(options, 0.012, 0.4, 0.0, random);
  for (VelocitySample& sample : samples) sample.standard_uncertainty = 0.01;
  EXPECT_NO_THROW(fit_kinematic(samples, options));
  samples[3].standard_uncertainty = 0.0;
  EXPECT_THROW(fit_kinematic(samples, options), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::calibrate
