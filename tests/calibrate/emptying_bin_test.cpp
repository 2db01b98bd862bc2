// A bin that empties, simulated from a filmed bed and from one of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/flow/bulk_measure.h"
#include "calibrate/problem.h"
#include "tests/support/parameters.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::parameters;
using tests::TemporaryFolder;

// A bin of buttons with the orifice of the floor in its middle.
datasets::Experiment bin(double orifice, int count, double semi_major = 0.0069) {
  const TemporaryFolder folder;
  folder.write("curve.csv", "time_s,mass_kg\n0,0\n1,0\n");
  const std::string text = fmt::format(R"(title = "A bin"
[particle]
count = {}
mass_g = 0.332
plate = {{semi_major_m = {}, semi_minor_m = {}, thickness_mm = 2.3}}
[material]
elastic_modulus_gpa = 3.5
poisson_ratio = 0.3
friction_particle_particle = 0.3
friction_particle_wall = 0.3
restitution = 0.7
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 120
bin_height_mm = 200
front_back_gap_mm = 2.6
[[replicate]]
discharge = "curve.csv"
orifice_width_m = {}
)",
                                       count,
                                       semi_major,
                                       std::min(semi_major, 0.0053),
                                       orifice);
  // An experiment takes two replicates; one is enough to be simulated
  const std::string replicate = text.substr(text.find("[[replicate]]"));
  datasets::Experiment experiment =
      datasets::load_experiment(folder.write("bin.toml", text + replicate + "name = \"other\"\n"));
  experiment.replicates.resize(1);
  return experiment;
}

// Rows of buttons that touch nothing.
std::vector<datasets::Pose> rows(int count) {
  std::vector<datasets::Pose> bed;
  for (int i = 0; i < count; ++i)
    bed.push_back({-0.045 + 0.015 * (i % 7), 0.0054 + 0.0108 * (i / 7), 0.0});
  return bed;
}

// As a film of 0.6 s at 100 frames a second that shows this bed; without one, as a weighed bin.
Problem problem_of(const datasets::Experiment& experiment,
                   const std::vector<datasets::Pose>& bed = {}) {
  datasets::Recording recording;
  if (bed.empty()) {
    recording.discharge = datasets::DischargeCurve{.time = {0.0, 0.6}, .mass = {0.0, 0.0}};
  } else {
    const int particles = static_cast<int>(bed.size());
    datasets::Trajectories tracks = datasets::make_trajectories(61, particles, false);
    for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
      tracks.time[frame] = 0.01 * static_cast<double>(frame);
      for (std::size_t i = 0; i < bed.size(); ++i) tracks.poses[tracks.index(frame, i)] = bed[i];
    }
    recording.tracks = std::move(tracks);
  }
  return plan_problem(experiment, {&recording, 1});
}

EngineRun simulate(const Problem& problem, std::uint64_t seed = 1) {
  SimulationSpec spec =
      problem.spec_of(0, parameters(0.3, 0.3, 0.7), problem.largest_time_step_fraction(), seed);
  const EngineRun run = problem.engine->run(spec, {});
  EXPECT_EQ(run.status, RunStatus::completed) << run.message;
  return run;
}

BulkMeasurement measured(const Problem& problem, std::uint64_t seed = 1) {
  const datasets::Experiment& experiment = problem.experiment;
  return measure_bulk(*simulate(problem, seed).recording.tracks,
                      bulk_rig({.particle = experiment.particle,
                                .rig = experiment.replicates.front().rig,
                                .measurement = experiment.measurement}));
}

// A button that lies on the stopper leaves as soon as its centre has fallen through the floor:
//   t = sqrt(2 z / g)
TEST(EmptyingBin, ALoneButtonFallsFreely) {
  const std::vector<double> times =
      measured(problem_of(bin(0.05, 1), {{0.0, 0.0053, 0.0}})).discharge.times;
  ASSERT_EQ(times.size(), 1U);
  // Exit times are interpolated linearly between frames 10 ms apart: v dt / 8 at most, over v
  EXPECT_NEAR(times[0], std::sqrt(2.0 * 0.0053 / 9.81), 1.3e-3);
}

TEST(EmptyingBin, EveryButtonLeavesOrStays) {
  const Discharge discharge = measured(problem_of(bin(0.07, 49), rows(49))).discharge;
  EXPECT_EQ(discharge.particles, 49);
  EXPECT_GT(discharge.times.size(), 30U);
  EXPECT_LT(discharge.times.size(), 49U);
  EXPECT_TRUE(std::is_sorted(discharge.times.begin(), discharge.times.end()));
}

// A disc is one sphere: it lies the same however it is turned.
TEST(EmptyingBin, DiscsDoNotCareHowTheyAreTurned) {
  const datasets::Experiment discs = bin(0.07, 21, 0.0053);
  std::vector<datasets::Pose> bed = rows(21);
  const std::vector<double> times = measured(problem_of(discs, bed)).discharge.times;
  EXPECT_GT(times.size(), 0U);
  for (std::size_t i = 0; i < bed.size(); ++i) bed[i].angle = 0.7 * static_cast<double>(i);
  const std::vector<double> turned = measured(problem_of(discs, bed)).discharge.times;
  ASSERT_EQ(turned.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(turned[i], times[i], 1.0e-9);
}

TEST(EmptyingBin, GivesTheSameForTheSameSeedAndOthersForAnother) {
  Problem problem = problem_of(bin(0.07, 49), rows(49));
  problem.scenes.front().spec.start.standard_deviation = {5e-5, 5e-5, 0.01};
  const std::vector<double> once = measured(problem, 1).discharge.times;
  EXPECT_EQ(once, measured(problem, 1).discharge.times);
  EXPECT_NE(once, measured(problem, 2).discharge.times);
}

// Without a filmed bed every seed prepares its own: all particles, as dense as a settled bed of
// ellipses without friction (0.84 in thesis 4.3.4), and another one for another seed.
TEST(EmptyingBin, PreparesABedWhereTheFilmTellsNone) {
  Problem problem = problem_of(bin(0.01061, 49));  // as wide as a plate: nothing leaves
  const BulkMeasurement run = measured(problem);
  EXPECT_EQ(run.discharge.particles, 49);
  EXPECT_TRUE(run.discharge.times.empty());
  EXPECT_GT(run.at_rest.solid_fraction, 0.70);
  EXPECT_LT(run.at_rest.solid_fraction, 0.90);
  EXPECT_EQ(run.at_rest.surface, measured(problem, 1).at_rest.surface);
  EXPECT_NE(run.at_rest.surface, measured(problem, 2).at_rest.surface);
  // Nor do two films share a bed.
  ++problem.scenes.front().spec.scene.fill.number;
  EXPECT_NE(run.at_rest.surface, measured(problem).at_rest.surface);
}

TEST(EmptyingBin, AClosedBinKeepsAll) {
  EXPECT_TRUE(measured(problem_of(bin(0.01061, 21), rows(21))).discharge.times.empty());
}

TEST(EmptyingBin, AnOverfullBedIsAResultWithAReason) {
  const Problem problem =
      problem_of(bin(0.05, 12), std::vector<datasets::Pose>(12, {0.0, 0.01, 0.0}));
  const EngineRun run = problem.engine->run(
      problem.spec_of(0, parameters(0.3, 0.3, 0.7), problem.largest_time_step_fraction(), 1), {});
  EXPECT_TRUE(run.status == RunStatus::completed || !run.message.empty());
}

// The overlap of the hardest impact, a fall by the width of the orifice, is 1 % of the diameter in
// a bed this soft; a stiff bench value is lowered to that, a soft one is kept.
TEST(EmptyingBin, TheModulusIsLoweredAsFarAsOverlapsAllow) {
  datasets::Experiment experiment = bin(0.05, 7);
  const double softened = problem_of(experiment, rows(7)).simulated_modulus;
  EXPECT_LT(softened, 3.5e9);
  const double reduced = softened / (2.0 * (1.0 - 0.09));
  const double diameter = experiment.particle.diameter;
  const double stiffness = 4.0 / 3.0 * reduced * std::sqrt(0.25 * diameter);
  const double impact = std::sqrt(2.0 * 9.81 * 0.05);
  const double overlap = std::pow(1.25 * 0.5 * 0.332e-3 * impact * impact / stiffness, 0.4);
  EXPECT_NEAR(overlap / diameter, 0.01, 1e-6);
  experiment.material.elastic_modulus = 0.5 * softened;
  EXPECT_EQ(problem_of(experiment, rows(7)).simulated_modulus, 0.5 * softened);
}

}  // namespace
}  // namespace graintruth::calibrate
