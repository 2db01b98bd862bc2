#include "calibrate/flow/bulk_measure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace graintruth::calibrate {
namespace {

const BulkRig rig{.width = 0.15,
                  .orifice = 0.075,
                  .particle_area = std::numbers::pi * 0.0069 * 0.0053,
                  .particle_diameter = 2.0 * std::sqrt(0.0069 * 0.0053),
                  .particle_mass = 0.332e-3};

// Particles that fall through the floor at given times at 0.5 m/s, filmed at 100 frames/s.
datasets::Trajectories falling(const std::vector<double>& exits, double duration) {
  const auto frames = static_cast<std::size_t>(duration * 100.0) + 1;
  auto tracks = datasets::make_trajectories(frames, static_cast<int>(exits.size()), false);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    tracks.time[frame] = 0.01 * static_cast<double>(frame);
    for (std::size_t particle = 0; particle < exits.size(); ++particle) {
      const double z = 0.5 * (exits[particle] - tracks.time[frame]);
      if (z < -0.06) continue;  // out of the picture
      tracks.poses[tracks.index(frame, particle)] = {0.0, z, 0.0};
    }
  }
  return tracks;
}

std::vector<double> regular(int count, double first, double gap) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(first + gap * i);
  return times;
}

TEST(Discharge, TimesAreInterpolatedBetweenFrames) {
  const std::vector<double> exits = {0.1234, 0.3, 0.5678};
  const Discharge discharge = measure_discharge(falling(exits, 1.0), rig);
  ASSERT_EQ(discharge.times.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(discharge.times[i], exits[i], 1e-12);
  EXPECT_EQ(discharged_by(discharge, 0.2), 1);
  EXPECT_EQ(discharged_by(discharge, 0.9), 3);
}

TEST(Discharge, OneLostJustAboveTheOrificeHasLeftAndOneLostInTheBedHasNot) {
  auto tracks = datasets::make_trajectories(3, 2, false);
  tracks.time = {0.0, 0.01, 0.02};
  tracks.poses[tracks.index(0, 0)] = {0.0, 0.003, 0.0};
  tracks.poses[tracks.index(0, 1)] = {0.06, 0.003, 0.0};  // beside the orifice
  const Discharge discharge = measure_discharge(tracks, rig);
  EXPECT_EQ(discharge.particles, 2);
  ASSERT_EQ(discharge.times.size(), 1U);
  EXPECT_EQ(discharge.times[0], 0.01);
}

TEST(SteadyRate, OfRegularExitsIsExact) {
  const auto steady =
      steady_rate(measure_discharge(falling(regular(200, 0.3, 0.0125), 3.0), rig), rig);
  ASSERT_TRUE(steady);
  EXPECT_NEAR(steady->rate, 0.332e-3 / 0.0125, 1e-9);
  EXPECT_NEAR(steady->standard_error, 0.0, 1e-9);
  EXPECT_GE(steady->particles, 138);
}

// Rates of exits at random intervals: unbiased, and with an error that is what repeats show.
TEST(SteadyRate, StandardErrorIsThatOfRepeats) {
  std::mt19937 random(3);
  std::gamma_distribution<double> gap(4.0, 0.0125 / 4.0);
  double sum = 0.0, square = 0.0, stated = 0.0;
  constexpr int repeats = 300;
  const double truth = 0.332e-3 / 0.0125;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    Discharge discharge{.particles = 200, .from = 0.0, .to = 5.0, .times = {}};
    double time = 0.3;
    for (int i = 0; i < 200; ++i) discharge.times.push_back(time += gap(random));
    const auto steady = steady_rate(discharge, rig);
    ASSERT_TRUE(steady);
    sum += steady->rate / repeats;
    square += std::pow(steady->rate - truth, 2) / repeats;
    stated += steady->standard_error / repeats;
  }
  EXPECT_NEAR(sum, truth, 0.02 * truth);
  EXPECT_NEAR(stated / std::sqrt(square), 1.0, 0.3);
}

TEST(SteadyRate, IsNotInventedWhereTheFlowStutters) {
  // Ten particles at a time with a second between
  std::vector<double> exits;
  for (int burst = 0; burst < 10; ++burst)
    for (int i = 0; i < 10; ++i) exits.push_back(burst + 0.01 * i);
  Discharge discharge{.particles = 100, .from = 0.0, .to = 11.0, .times = exits};
  EXPECT_FALSE(steady_rate(discharge, rig));
  EXPECT_EQ(find_arching(discharge, rig).pauses.size(), 9U);
  EXPECT_FALSE(find_arching(discharge, rig).jammed);
  discharge.particles = 120;
  EXPECT_FALSE(find_arching(discharge, rig).jammed);  // a heap beside the orifice
  discharge.over_orifice = 20;
  EXPECT_TRUE(find_arching(discharge, rig).jammed);
}

TEST(SteadyRate, LeavesOutTheStartAndTheEnd) {
  // The last fifth runs at a quarter of the rate.
  std::vector<double> exits = regular(160, 0.2, 0.01);
  for (int i = 0; i < 40; ++i) exits.push_back(exits.back() + 0.04);
  const auto steady = steady_rate({.particles = 200, .from = 0.0, .to = 5.0, .times = exits}, rig);
  ASSERT_TRUE(steady);
  EXPECT_NEAR(steady->rate, 0.332e-3 / 0.01, 0.002 * 0.0332);
}

// The rate of a weighed curve is that of the particles that made it, whatever the cell's interval.
TEST(SteadyRate, OfADischargeCurveIsThatOfItsParticles) {
  std::mt19937 random(7);
  std::gamma_distribution<double> gap(4.0, 0.0125 / 4.0);
  std::vector<double> exits;
  double now = 0.3;
  for (int i = 0; i < 200; ++i) exits.push_back(now += gap(random));
  const auto counted = steady_rate({.particles = 200, .to = 4.0, .times = exits}, rig);
  ASSERT_TRUE(counted);
  for (const double interval : {0.002, 0.02, 0.1, 0.25}) {
    datasets::DischargeCurve curve;
    for (double time = 0.0; time <= 4.0; time += interval) {
      curve.time.push_back(time);
      const auto left = std::upper_bound(exits.begin(), exits.end(), time) - exits.begin();
      curve.mass.push_back(static_cast<double>(left) * rig.particle_mass);
    }
    const BulkMeasurement weighed = measure_bulk(curve, 200, rig);
    EXPECT_FALSE(weighed.of_tracks);
    EXPECT_EQ(weighed.discharge.times.size(), 200U);
    const auto steady = steady_rate(weighed.discharge, rig);
    ASSERT_TRUE(steady) << interval;
    EXPECT_NEAR(steady->rate, counted->rate, 0.02 * counted->rate) << interval;
    EXPECT_EQ(steady->particles % weighed.discharge.together, 0);
  }
}

// Few samples of many particles: the error comes from the samples, not from as many particles as
// have been thought in between.
TEST(SteadyRate, OfACoarseCurveIsNoSurerThanItsSamples) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 0.08);
  constexpr int repeats = 200, particles = 5000;
  double square = 0.0, stated = 0.0;
  const double truth = rig.particle_mass * particles / 5.0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    datasets::DischargeCurve curve{{0.0}, {0.0}};
    for (int sample = 1; sample <= 50; ++sample) {
      curve.time.push_back(0.1 * sample);
      curve.mass.push_back(curve.mass.back() + 0.1 * truth * (1.0 + noise(random)));
    }
    const auto steady = steady_rate(measure_discharge(curve, particles, rig), rig);
    ASSERT_TRUE(steady);
    square += std::pow(steady->rate - truth, 2) / repeats;
    stated += steady->standard_error / repeats;
  }
  EXPECT_NEAR(stated / std::sqrt(square), 1.0, 0.35);
}

TEST(BedShape, OfAFullLattice) {
  // 12 columns of 10 discs of one diameter, upright square packing
  const double d = rig.particle_diameter;
  auto tracks = datasets::make_trajectories(1, 120, false);
  tracks.time = {0.0};
  const BulkRig snug{.width = 12 * d,
                     .orifice = 0.05,
                     .particle_area = rig.particle_area,
                     .particle_diameter = d,
                     .particle_mass = 1.0};
  for (std::size_t i = 0; i < 120; ++i)
    tracks.poses[i] = {
        (static_cast<double>(i % 12) - 5.5) * d, (static_cast<double>(i / 12) + 0.5) * d, 0.0};
  const BedShape bed = measure_bed(tracks, 0, snug);
  EXPECT_NEAR(bed.area, 12 * d * 10 * d, 1e-12);
  EXPECT_NEAR(bed.solid_fraction, std::numbers::pi / 4.0, 1e-12);
  EXPECT_NEAR(bed.areal_density, 120 / bed.area, 1e-9);
}

// Particles that sink with the velocity of a kinematic profile through a band that is always full:
// the profile is found again, and the flux is the integral of v rho.
TEST(VelocityProfile, IsFoundAgainAndClosesTheMassBalance) {
  const KinematicOptions shape{.height = 0.09, .orifice = 0.075};
  const double d = rig.particle_diameter, B = 0.01;
  constexpr int columns = 24, rows = 60;
  auto tracks = datasets::make_trajectories(40, columns * rows, false);
  for (std::size_t frame = 0; frame < 40; ++frame) {
    tracks.time[frame] = 0.01 * static_cast<double>(frame);
    for (int column = 0; column < columns; ++column) {
      const double x = ((column + 0.5) / columns - 0.5) * rig.width;
      for (int row = 0; row < rows; ++row) {
        const double z =
            0.003 + row * 0.5 * d - tracks.time[frame] * kinematic_velocity(shape, B, 0.3, x);
        tracks.poses[tracks.index(frame, static_cast<std::size_t>(column * rows + row))] = {
            x, z, 0.0};
      }
    }
  }
  const VelocityProfile profile = measure_profile(tracks, rig, 0.09, 0.0, 0.4);
  EXPECT_EQ(profile.samples.size(), 12U);
  KinematicOptions free = shape;
  EXPECT_NEAR(fit_kinematic(profile.samples, free).B, B, 0.03 * B);
  double expected = 0.0;
  const double density = rig.particle_mass / (rig.width / columns * 0.5 * d);
  for (int column = 0; column < columns; ++column) {
    const double x = ((column + 0.5) / columns - 0.5) * rig.width;
    expected += density * kinematic_velocity(shape, B, 0.3, x) * rig.width / columns;
  }
  EXPECT_NEAR(profile.flux, expected, 0.03 * expected);
  EXPECT_NEAR(profile.areal_density, density, 0.03 * density);
}

// A stack beside the orifice whose upper half slides at `speed`, filmed twice 0.02 s apart.
datasets::Trajectories stack_sliding_at(double speed) {
  constexpr int count = 10;
  auto tracks = datasets::make_trajectories(2, count, false);
  tracks.time = {0.0, 0.02};
  for (std::size_t frame = 0; frame < 2; ++frame) {
    for (std::size_t p = 0; p < count; ++p) {
      const double z = rig.particle_diameter * (static_cast<double>(p) + 0.5);
      const double moved = p < count / 2 ? 0.0 : speed * tracks.time[frame];
      tracks.poses[tracks.index(frame, p)] = {-0.06, z - moved, 0.0};
    }
  }
  return tracks;
}

TEST(Stagnant, EndsWhereParticlesMoveFasterThanTheRuleSays) {
  const double limit = datasets::stagnant_speed(rig.particle_diameter, rig.gravity);
  const auto height_of = [](const datasets::Trajectories& tracks) {
    const datasets::StagnantMap map = measure_stagnant(tracks, rig, 0.2, 0, 1);
    const auto heights = datasets::stagnant_heights(map, rig.orifice);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < map.x.size(); ++i)
      if (std::abs(map.x[i] + 0.06) < std::abs(map.x[nearest] + 0.06)) nearest = i;
    return heights[nearest];
  };
  const double row = rig.particle_diameter / 8.0;
  EXPECT_NEAR(height_of(stack_sliding_at(1.2 * limit)), 5.0 * rig.particle_diameter, row);
  // Slower than that the whole stack stands; it ends a little above its last particle's middle
  EXPECT_NEAR(height_of(stack_sliding_at(0.8 * limit)), 10.1 * rig.particle_diameter, row);
}

TEST(Stagnant, OneThatIsNotSeenAgainMoves) {
  auto tracks = stack_sliding_at(0.0);
  tracks.poses[tracks.index(1, 4)] = {};
  const datasets::StagnantMap map = measure_stagnant(tracks, rig, 0.2, 0, 1);
  const auto heights = datasets::stagnant_heights(map, rig.orifice);
  EXPECT_NEAR(*std::max_element(heights.begin(), heights.begin() + 6),
              4.0 * rig.particle_diameter,
              rig.particle_diameter / 8.0);
}

}  // namespace
}  // namespace graintruth::calibrate
