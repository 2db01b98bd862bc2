#include "sim/time_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

constexpr Material kButton{3.5e9, 0.30};
constexpr double kButtonDensity = 1256.4;

// Errata item 1: the printed steps are those of 1.28 without pi.
TEST(RayleighTimeStep, ThesisDigitsWithoutPi) {
  const double one_cm = rayleigh_time_step(0.01, kButtonDensity, kButton) / std::numbers::pi;
  EXPECT_NEAR(one_cm, 1.044e-5, 5e-9);
  const double small = rayleigh_time_step(0.00433, kButtonDensity, kButton) / std::numbers::pi;
  EXPECT_NEAR(0.04 / small, 8850.0, 10.0);
}

TEST(HertzImpact, MatchesTheMicroRigByHand) {
  // Body on rigid wall at 0.1 m/s: k = 4/3 7.852e9 sqrt(0.022225) = 1.5608e9
  const HertzImpact impact = hertz_impact(6.89e9 / (1.0 - 0.35 * 0.35), 0.022225, 0.142, 0.1);
  EXPECT_NEAR(impact.deepest_overlap, std::pow(5.0 * 0.142 * 0.01 / (4.0 * 1.5608e9), 0.4), 1e-9);
  EXPECT_NEAR(impact.duration, 2.9432751843 * impact.deepest_overlap / 0.1, 1e-12);
}

TEST(ChooseTimeStep, IsBoundedByContactsAndByFraction) {
  const Scene scene = scenes::micro_rig();
  const TimeStepLimits limits = time_step_limits(scene, 0.1);
  EXPECT_LE(choose_time_step(scene, {.fraction = 1.0, .impact_speed = 0.1}),
            limits.contact_duration / 20.0 * (1.0 + 1e-12));
  EXPECT_DOUBLE_EQ(choose_time_step(scene, {.fraction = 0.1}), 0.1 * critical_time_step(scene));
  EXPECT_THROW(choose_time_step(scene, {.fraction = 1.5}), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
