// A box of three dimensions that runs out through a slot.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "calibrate/problem.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

// The template of `graintruth new`, with text changed.
std::string silo(std::initializer_list<std::pair<std::string, std::string>> changes = {}) {
  std::ifstream file(GRAINTRUTH_SOURCE_DIR "/app/new/box_silo/experiment.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  for (const auto& [from, to] : changes) {
    const auto place = text.find(from);
    if (place == std::string::npos) throw std::logic_error(from);
    text.replace(place, from.size(), to);
  }
  return text;
}

class BoxSilo : public testing::Test {
 protected:
  BoxSilo() {
    for (const char* name : {"wide1.csv", "wide2.csv", "narrow1.csv", "narrow2.csv"})
      folder_.write(name, "time_s,mass_g\n0,0\n0.5,100\n1,150\n");
  }

  datasets::Experiment load(const std::string& text) {
    return datasets::load_experiment(folder_.write("experiment.toml", text));
  }

  // A wider slot is another condition.
  Problem problem_of(const datasets::Experiment& experiment) {
    const std::vector<datasets::Recording> recordings(
        experiment.replicates.size(),
        {.discharge = datasets::DischargeCurve{.time = {0.0, 0.5, 1.0}, .mass = {0.0, 0.1, 0.15}}});
    return plan_problem(experiment, recordings);
  }

  std::string complaint(const std::string& text) {
    try {
      load(text);
    } catch (const datasets::InputError& error) {
      return error.what();
    }
    return "";
  }

  tests::TemporaryFolder folder_;
};

TEST_F(BoxSilo, KeepsEveryGrainUntilTheSlotOpensAndEmptiesTheFasterTheWider) {
  const datasets::Experiment experiment = load(silo({{"count = 300", "count = 120"}}));
  const Problem problem = problem_of(experiment);
  ASSERT_EQ(problem.conditions.size(), 2U);
  std::vector<double> left;  // kg, at 0.3 s, of the narrow slot and of the wide one
  for (std::size_t scene = 0; scene < problem.scenes.size(); ++scene) {
    const SimulationSpec spec =
        problem.spec_of(scene, datasets::bench_parameters(experiment), 0.3, 1);
    EXPECT_FALSE(spec.scene.is_planar);
    EXPECT_NEAR(spec.scene.phases.back().duration, 1.0, 1e-9);  // as long as the curves
    const EngineRun run = problem.engine->run(spec, {});
    ASSERT_EQ(run.status, RunStatus::completed) << run.message;
    const datasets::DischargeCurve& curve = *run.recording.discharge;
    EXPECT_EQ(curve.mass.front(), 0.0);
    EXPECT_LE(curve.mass.back(), 120 * 0.6e-3 + 1e-9);
    EXPECT_GT(curve.mass.back(), 0.5 * 120 * 0.6e-3);
    left.push_back(curve.mass[30]);
  }
  EXPECT_LT(left[0], left[1]);
}

TEST_F(BoxSilo, TakesGrainsOfThreeDimensions) {
  EXPECT_EQ(complaint(silo({{"{x_mm = 3, radius_mm = 4}", "{x_mm = 3, y_mm = 2, radius_mm = 4}"}})),
            "");
}

TEST_F(BoxSilo, ThatCannotBeIsRefusedInOneSentence) {
  const auto expect_refusal = [&](const std::string& text, std::vector<std::string> parts) {
    const std::string said = complaint(text);
    for (const std::string& part : parts) EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  expect_refusal(silo({{"slot_width_mm = 45", "slot_width_mm = 120"}}),
                 {"experiment.toml:59", "'replicate.slot_width_mm'", "120 mm wide"});
  expect_refusal(silo({{"box_width_mm = 120", "box_width_mm = 5"},
                       {"slot_width_mm = 60", "slot_width_mm = 4"}}),
                 {"experiment.toml:32", "'rig.box_width_mm'", "no grain of"});
  expect_refusal(silo({{"box_depth_mm = 50\n", ""}}), {"'rig.box_depth_m'", "is missing"});
  expect_refusal(silo({{"slot_width_mm = 60\n", ""}}), {"'replicate.slot_width", "is missing"});
}

}  // namespace
}  // namespace graintruth::calibrate
