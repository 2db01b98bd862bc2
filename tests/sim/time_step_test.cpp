#include "sim/laws/time_step.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

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
