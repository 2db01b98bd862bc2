// The adapter to the simulator for particles that run out of a bin.
#include "calibrate/bin_simulator.h"

#include <gtest/gtest.h>

#include <cmath>

namespace graintruth::calibrate {
namespace {

// A bin of buttons with the orifice of the floor in its middle.
BinStart bin(double orifice, std::vector<datasets::Pose> bed) {
  BinStart start;
  datasets::Experiment& experiment = start.experiment;
  experiment.particle = {.count = static_cast<int>(bed.size()),
                         .mass = 0.332e-3,
                         .plate = datasets::EllipticalPlate{0.0069, 0.0053, 0.0023}};
  experiment.material = {.elastic_modulus = 3.5e9, .poisson_ratio = 0.3};
  experiment.rig.bin = datasets::FlatBin{.width = 0.12, .height = 0.2, .orifice_width = orifice};
  experiment.rig.walls = {{"side_left", -0.06, 0.0, -0.06, 0.2},
                          {"side_right", 0.06, 0.0, 0.06, 0.2},
                          {"floor_left", -0.06, 0.0, -0.5 * orifice, 0.0},
                          {"floor_right", 0.5 * orifice, 0.0, 0.06, 0.0}};
  start.rig = bulk_rig(experiment, {.name = "film"});
  start.bed = std::move(bed);
  start.duration = 0.6;
  start.frame_interval = 0.01;
  start.profile_height = 0.02;
  start.impact_speed = std::sqrt(2.0 * 9.81 * orifice);
  return start;
}

// Rows of buttons that touch nothing.
std::vector<datasets::Pose> rows(int count) {
  std::vector<datasets::Pose> bed;
  for (int i = 0; i < count; ++i)
    bed.push_back({-0.045 + 0.015 * (i % 7), 0.0054 + 0.0108 * (i / 7), 0.0});
  return bed;
}

SimulationRequest request(const BinStart& start, std::uint64_t seed) {
  return {.parameters = {0.3, 0.3, 0.7},
          .time_step_fraction = largest_time_step_fraction(start),
          .seed = seed};
}

// A button that lies on the stopper leaves as soon as its centre has fallen through the floor:
//   t = sqrt(2 z / g)
TEST(BinSimulator, ALoneButtonFallsFreely) {
  const BinStart start = bin(0.05, {{0.0, 0.0053, 0.0}});
  const SimulatedRun run = make_bin_simulator(start, {})(request(start, 1));
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  ASSERT_EQ(run.bin.discharge.times.size(), 1U);
  // Exit times are interpolated linearly between frames 10 ms apart: v dt / 8 at most, over v
  EXPECT_NEAR(run.bin.discharge.times[0], std::sqrt(2.0 * 0.0053 / 9.81), 1.3e-3);
}

TEST(BinSimulator, EveryButtonLeavesOrStays) {
  const BinStart start = bin(0.07, rows(49));
  const SimulatedRun run = make_bin_simulator(start, {})(request(start, 1));
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  EXPECT_EQ(run.bin.discharge.particles, 49);
  EXPECT_GT(run.bin.discharge.times.size(), 30U);
  EXPECT_LT(run.bin.discharge.times.size(), 49U);
  EXPECT_EQ(run.bin.profile.height, start.profile_height);
  EXPECT_TRUE(std::is_sorted(run.bin.discharge.times.begin(), run.bin.discharge.times.end()));
}

// A disc is one sphere: it lies the same however it is turned.
TEST(BinSimulator, DiscsDoNotCareHowTheyAreTurned) {
  BinStart start = bin(0.07, rows(21));
  start.experiment.particle.plate = datasets::EllipticalPlate{0.0054, 0.0054, 0.0023};
  const SimulatedRun run = make_bin_simulator(start, {})(request(start, 1));
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  EXPECT_GT(run.bin.discharge.times.size(), 0U);
  for (std::size_t i = 0; i < start.bed.size(); ++i)
    start.bed[i].angle = 0.7 * static_cast<double>(i);
  const SimulatedRun turned = make_bin_simulator(start, {})(request(start, 1));
  ASSERT_EQ(turned.bin.discharge.times.size(), run.bin.discharge.times.size());
  for (std::size_t i = 0; i < run.bin.discharge.times.size(); ++i)
    EXPECT_NEAR(turned.bin.discharge.times[i], run.bin.discharge.times[i], 1.0e-9);
}

TEST(BinSimulator, GivesTheSameForTheSameSeedAndOthersForAnother) {
  BinStart start = bin(0.07, rows(49));
  start.standard_deviation = {5e-5, 5e-5, 0.01};
  const Simulator simulator = make_bin_simulator(start, {});
  const SimulatedRun one = simulator(request(start, 1));
  EXPECT_EQ(one.bin.discharge.times, simulator(request(start, 1)).bin.discharge.times);
  EXPECT_NE(one.bin.discharge.times, simulator(request(start, 2)).bin.discharge.times);
}

// Without a filmed bed every seed prepares its own: all particles, as dense as a settled bed of
// ellipses without friction (0.84 in thesis 4.3.4), and another one for another seed.
TEST(BinSimulator, PreparesABedWhereTheFilmTellsNone) {
  BinStart start = bin(0.008, rows(49));  // an orifice that lets nothing through
  start.bed.clear();
  start.profile_height.reset();
  const Simulator simulator = make_bin_simulator(start, {});
  const SimulatedRun run = simulator(request(start, 1));
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  EXPECT_EQ(run.bin.discharge.particles, 49);
  EXPECT_TRUE(run.bin.discharge.times.empty());
  EXPECT_GT(run.bin.at_rest.solid_fraction, 0.70);
  EXPECT_LT(run.bin.at_rest.solid_fraction, 0.90);
  EXPECT_NE(run.bin.at_rest.surface, simulator(request(start, 2)).bin.at_rest.surface);
  EXPECT_EQ(run.bin.at_rest.surface, simulator(request(start, 1)).bin.at_rest.surface);
  // Nor do two films share a bed.
  start.prepared_bed = 1;
  EXPECT_NE(run.bin.at_rest.surface,
            make_bin_simulator(start, {})(request(start, 1)).bin.at_rest.surface);
}

TEST(BinSimulator, AClosedBinKeepsAll) {
  const BinStart start = bin(0.008, rows(21));
  const SimulatedRun run = make_bin_simulator(start, {})(request(start, 1));
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  EXPECT_TRUE(run.bin.discharge.times.empty());
}

TEST(BinSimulator, AnOverfullBedIsAResultWithAReason) {
  std::vector<datasets::Pose> bed(12, datasets::Pose{0.0, 0.01, 0.0});
  const SimulatedRun run = make_bin_simulator(bin(0.05, bed), {})(request(bin(0.05, bed), 1));
  EXPECT_TRUE(run.status == RunStatus::completed || !run.message.empty());
}

// The overlap of the hardest impact in a bed this soft is 1 % of the diameter; a stiff bench value
// is lowered to that, a soft one is kept.
TEST(BinSimulator, TheModulusIsLoweredAsFarAsOverlapsAllow) {
  BinStart start = bin(0.05, rows(7));
  const double softened = simulated_modulus(start);
  EXPECT_LT(softened, 3.5e9);
  const double reduced = softened / (2.0 * (1.0 - 0.09));
  const double diameter = start.rig.particle_diameter;
  const double stiffness = 4.0 / 3.0 * reduced * std::sqrt(0.25 * diameter);
  const double overlap =
      std::pow(1.25 * 0.5 * 0.332e-3 * std::pow(start.impact_speed, 2) / stiffness, 0.4);
  EXPECT_NEAR(overlap / diameter, 0.01, 1e-6);
  start.experiment.material.elastic_modulus = 0.5 * softened;
  EXPECT_EQ(simulated_modulus(start), 0.5 * softened);
}

}  // namespace
}  // namespace graintruth::calibrate
