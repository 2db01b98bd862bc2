// A calibration of another engine than the embedded one, through the registry.
#include <gtest/gtest.h>

#include <algorithm>

#include "calibrate/calibration.h"
#include "datasets/store/input_error.h"
#include "tests/support/sliding_block_engine.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

const bool is_known = (make_known(tests::sliding_block), true);

// A block on a slope: the scene brings what every experiment has, the engine looks at one friction.
datasets::Experiment block_on_a_slope(const tests::TemporaryFolder& folder) {
  folder.write("curve.csv", "time_s,slid_m\n0,0\n1,1\n");
  std::string text = R"(title = "A block on a slope"
[rig]
kind = "scene"
scene = ")" GRAINTRUTH_SOURCE_DIR R"(/datasets/scenes/box_3d.toml"
[measure]
frame_interval_s = 0.1
frames = 8
observables = ["slid"]
[measure.slid]
column = "slid_m"
engine_curve = "slid_m"
unit = "m"
[tune]
friction_particle_wall = {lower = 0.0, upper = 0.6}
)";
  for (const char* name : {"a", "b", "c", "d", "e"})
    text += std::string("[[replicate]]\nname = \"") + name + "\"\ncurves = \"curve.csv\"\n";
  return datasets::load_experiment(folder.write("experiment.toml", text));
}

CalibrationResult calibrated(double friction, const std::string& executor, int jobs) {
  const tests::TemporaryFolder folder;
  const datasets::Experiment experiment = block_on_a_slope(folder);
  std::vector<datasets::Recording> recordings(experiment.replicates.size());
  for (std::size_t i = 0; i < recordings.size(); ++i)
    recordings[i].curves["slid_m"] = tests::SlidingBlock::slid(friction, 1000 + i);
  const Problem problem = make_problem(experiment, recordings, engine_named("sliding_block"));
  Journal journal(":memory:");
  const std::array experiments = {CalibratedExperiment{"block", &problem}};
  CalibrationOptions options = default_options(experiments);
  options.budget = 30;
  return calibrate(experiment, experiments, journal, *make_executor(executor, jobs), {}, options);
}

TEST(OtherEngines, AreCalibratedAsTheEmbeddedOneIs) {
  ASSERT_TRUE(is_known);
  const CalibrationResult result = calibrated(0.3, "threads", 2);
  const auto friction =
      std::find_if(result.calibrated.begin(), result.calibrated.end(), [](const auto& parameter) {
        return parameter.name == "friction_particle_wall";
      });
  ASSERT_NE(friction, result.calibrated.end());
  EXPECT_NEAR(friction->value, 0.3, 0.02);
  ASSERT_TRUE(friction->interval);
  EXPECT_LT(friction->interval->lower, 0.3);
  EXPECT_GT(friction->interval->upper, 0.3);
}

TEST(OtherEngines, AreNamedWhereAnEngineIsNotKnown) {
  try {
    engine_named("abacus");
    FAIL();
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("embedded, command, lammps, liggghts, sliding_block"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace graintruth::calibrate
