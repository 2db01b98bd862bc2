// A drum that turns and a column that collapses, from their templates to the outlines of their
// beds.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "calibrate/observables/bed_profile.h"
#include "calibrate/observables/steady_surface.h"
#include "calibrate/problem.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using Changes = std::initializer_list<std::pair<std::string, std::string>>;

class PouredRigs : public testing::Test {
 protected:
  // The template of `graintruth new`, with text changed.
  datasets::Experiment load(const std::string& name, Changes changes) {
    std::ifstream file(GRAINTRUTH_SOURCE_DIR "/app/new/" + name + "/experiment.toml");
    std::string text(std::istreambuf_iterator<char>(file), {});
    for (const auto& [from, to] : changes) {
      const auto place = text.find(from);
      if (place == std::string::npos) throw std::logic_error(from);
      text.replace(place, from.size(), to);
    }
    for (const char* table : {"slow1", "slow2", "fast1", "fast2", "collapse1", "collapse2"})
      folder_.write(std::string(table) + ".outline.csv", "time_s,column_m,height_m\n");
    return datasets::load_experiment(folder_.write("experiment.toml", text));
  }

  std::string complaint(const std::string& name, Changes changes) {
    try {
      load(name, changes);
    } catch (const datasets::InputError& error) {
      return error.what();
    }
    return "";
  }

  EngineRun run(const datasets::Experiment& experiment, std::size_t scene) {
    const std::vector<datasets::Recording> recordings(experiment.replicates.size());
    const Problem problem = plan_problem(experiment, recordings);
    return problem.engine->run(
        problem.spec_of(scene, datasets::bench_parameters(experiment), 0.5, 1), {});
  }

  Situation situation_of(const datasets::Experiment& experiment, std::size_t replicate) {
    return {.particle = experiment.particle,
            .rig = experiment.replicates[replicate].rig,
            .measurement = experiment.measurement};
  }

  tests::TemporaryFolder folder_;
};

TEST_F(PouredRigs, ADrumThatTurnsClockwiseCarriesItsBedUpOnTheLeft) {
  const datasets::Experiment experiment =
      load("rotating_drum",
           {{"count = 500", "count = 45"},
            {"drum_diameter_mm = 70", "drum_diameter_mm = 36"},
            {"drum_depth_mm = 16", "drum_depth_mm = 10"},
            {"[measure]", "[measure]\nframe_interval_s = 0.01\nframes = 41"},
            {"turning_rpm = 20", "turning_rpm = 40"},
            {"turning_rpm = 20", "turning_rpm = 40"}});
  const EngineRun made = run(experiment, 1);
  ASSERT_EQ(made.status, RunStatus::completed) << made.message;
  const datasets::Outline& outline = *made.recording.outline;
  EXPECT_NEAR(outline.time.front(), 0.25, 1e-3);  // 60 degrees at 40 rpm
  EXPECT_NEAR(outline.time.back(), 0.65, 1e-3);
  const auto surface = steady_surface(outline, situation_of(experiment, 2));
  ASSERT_TRUE(surface);
  EXPECT_LT(surface->slope, -0.2);
  EXPECT_GT(surface->slope, -1.2);
}

TEST_F(PouredRigs, AColumnRunsOutToTheRightOnly) {
  const datasets::Experiment experiment = load("column_collapse",
                                               {{"filled_mass_g = 25", "filled_mass_g = 4"},
                                                {"column_width_mm = 40", "column_width_mm = 17"},
                                                {"tank_depth_mm = 20", "tank_depth_mm = 11"},
                                                {"tank_length_mm = 200", "tank_length_mm = 90"}});
  EXPECT_EQ(experiment.particle.count, 48);
  const EngineRun made = run(experiment, 0);
  ASSERT_EQ(made.status, RunStatus::completed) << made.message;
  const Situation situation = situation_of(experiment, 0);
  const auto before = profile_at(*made.recording.outline, 0, situation);
  const auto after = profile_at_rest(made.recording, situation);
  ASSERT_TRUE(after);
  EXPECT_NEAR(foot_of(before, Side::right, situation), 0.017, 0.002);
  EXPECT_GT(foot_of(*after, Side::right, situation), 0.017 + experiment.particle.diameter);
  EXPECT_LT(foot_of(*after, Side::right, situation), 0.085);
  EXPECT_LT(after->z[*apex_of(*after)], 0.9 * before.z[*apex_of(before)]);
}

TEST_F(PouredRigs, ThatCannotBeAreRefusedInOneSentence) {
  const auto expect_refusal =
      [&](const std::string& name, Changes changes, std::vector<std::string> parts) {
        const std::string said = complaint(name, changes);
        for (const std::string& part : parts) EXPECT_NE(said.find(part), std::string::npos) << said;
      };
  expect_refusal("rotating_drum",
                 {{"count = 500", "count = 2000"}},
                 {"'rig.drum_diameter_mm'", "2000 grains fill to"});
  expect_refusal("rotating_drum", {{"drum_depth_mm = 16", "drum_depth_mm = 3"}}, {"4 mm long"});
  expect_refusal(
      "rotating_drum", {{"turning_rpm = 5", "turning_rpm = 0"}}, {"turning_rpm", "is 0"});
  expect_refusal("column_collapse",
                 {{"column_width_mm = 40", "column_width_mm = 300"}},
                 {"'rig.column_width_mm'", "200 mm long"});
  expect_refusal("column_collapse",
                 {{"tank_depth_mm = 20", "tank_depth_mm = 4"}},
                 {"'rig.tank_depth_mm'", "no room"});
}

}  // namespace
}  // namespace graintruth::calibrate
