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
#include "tests/calibrate/standing_grains.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using Changes = std::vector<std::pair<std::string, std::string>>;

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
    for (const char* table : {"draw1", "draw2"})
      folder_.write(std::string(table) + ".outline.csv", "surface,time_s,column_m,height_m\n");
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
  const datasets::Outline& outline = made.recording.outlines.front();
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
  const auto before = profile_at(made.recording.outlines.front(), 0, situation);
  const auto after = profile_at_rest(made.recording, situation);
  ASSERT_TRUE(after);
  EXPECT_NEAR(foot_of(before, Side::right, situation), 0.017, 0.002);
  EXPECT_GT(foot_of(*after, Side::right, situation), 0.017 + experiment.particle.diameter);
  EXPECT_LT(foot_of(*after, Side::right, situation), 0.085);
  EXPECT_LT(after->z[*apex_of(*after)], 0.9 * before.z[*apex_of(before)]);
}

// One layer of so few grains that both beds take a second or two to compute, above a slot of six
// grains that no arch closes.
const Changes small_draw_down = {{"upper_width_mm = 80", "upper_width_mm = 52"},
                                 {"slot_width_mm = 20", "slot_width_mm = 24"},
                                 {"gate_speed_mm_per_s = 300", "gate_speed_mm_per_s = 500"},
                                 {"fall_height_mm = 70", "fall_height_mm = 22"},
                                 {"lower_width_mm = 160", "lower_width_mm = 90"},
                                 {"box_depth_mm = 20", "box_depth_mm = 5.5"},
                                 {"restitution = 0.79", "restitution = 0.4"},
                                 {"filled_mass_g = 60", "filled_mass_g = 3.5"}};

TEST_F(PouredRigs, ABoxRunsDownIntoTheOneBelowAndLeavesNoColumnStanding) {
  const datasets::Experiment experiment = load("draw_down", small_draw_down);
  ASSERT_EQ(experiment.particle.count, 42);
  const std::vector<datasets::Recording> recordings(experiment.replicates.size());
  datasets::SceneFile file;
  static_cast<datasets::SceneData&>(file) =
      plan_problem(experiment, recordings)
          .spec_of(0, datasets::bench_parameters(experiment), 0.5, 1)
          .scene;
  const SceneRun run = run_scene(file, {});
  int above = 0, below = 0;
  for (const sim::Body& body : run.scene.bodies) {
    ++(body.position.z() > 0.0 ? above : below);
    EXPECT_GT(body.position.z(), -0.022) << "nobody leaves the lower box";
  }
  EXPECT_EQ(above + below, 42);
  EXPECT_GT(below, 15);
  EXPECT_GT(above, 1);
  EXPECT_EQ(standing_columns(run, experiment.particle.diameter), 0);
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
  expect_refusal("rotating_drum",
                 {{"drum_depth_mm = 16", "drum_depth_mm = 7\nperiodic_depth = true"}},
                 {"'rig.drum_depth_mm' is 7 mm", "two grains deep, 8 mm"});
  expect_refusal("column_collapse",
                 {{"column_width_mm = 40", "column_width_mm = 300"}},
                 {"'rig.column_width_mm'", "200 mm long"});
  expect_refusal("column_collapse",
                 {{"tank_depth_mm = 20", "tank_depth_mm = 4"}},
                 {"'rig.tank_depth_mm'", "no room"});
  expect_refusal("draw_down",
                 {{"slot_width_mm = 20", "slot_width_mm = 3.9"}},
                 {"'rig.slot_width_mm'", "none gets through"});
  expect_refusal("draw_down",
                 {{"slot_width_mm = 20", "slot_width_mm = 90"}},
                 {"'rig.slot_width_mm'", "only 80 mm wide"});
  expect_refusal("draw_down",
                 {{"gate_length_mm = 50", "gate_length_mm = 10"}},
                 {"'rig.gate_length_mm'", "the slot that the slide closes is 20 mm"});
  expect_refusal("draw_down",
                 {{"gate_speed_mm_per_s = 300", "gate_speed_mm_per_s = 0"}},
                 {"'rig.gate_speed_mm_per_s'", "is 0"});
  expect_refusal("draw_down",
                 {{"fall_height_mm = 70", "fall_height_mm = 7"}},
                 {"'rig.fall_height_mm'", "7 mm thick"});
  expect_refusal("draw_down",
                 {{"box_depth_mm = 20", "box_depth_mm = 4"}},
                 {"'rig.box_depth_mm'", "no room for a grain of 4 mm"});
  expect_refusal("draw_down",
                 {{"upper_height_mm = 60", "upper_height_mm = 10"}},
                 {"'rig.upper_height_mm'", "grains stand about"});
  expect_refusal("draw_down",
                 {{"lower_width_mm = 160", "lower_width_mm = 20"}},
                 {"'rig.lower_width_mm'", "less room"});
}

// A rig with several surfaces has every observable of outlines once for each, and none for all.
TEST_F(PouredRigs, ObservablesNameTheSurfaceOfSeveral) {
  const char* both = R"(["free_surface_upper", "free_surface_lower"])";
  const auto compare = [&](const std::string& names) { return load("draw_down", {{both, names}}); };
  const Observables observables(
      compare(R"(["shear_angle_upper", "angle_of_repose_lower", "bed_area_lower"])"));
  ASSERT_EQ(observables.all().size(), 3U);
  EXPECT_EQ(observables.all()[0]->words().title, "Shear angle, upper");
  const auto refusal = [&](const std::string& names) -> std::string {
    try {
      const datasets::Experiment experiment = compare(names);
      const Observables made(experiment);
    } catch (const datasets::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal(R"(["free_surface"])").find("'free_surface_upper' or 'free_surface_lower'"),
            std::string::npos)
      << refusal(R"(["free_surface"])");
  EXPECT_NE(refusal(R"(["free_surface_middle"])").find("known are "), std::string::npos);
}

}  // namespace
}  // namespace graintruth::calibrate
