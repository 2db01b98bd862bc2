// The bundled simulator of ten lines, calibrated as users do it.
#include <gtest/gtest.h>

#include <algorithm>

#include "calibrate/calibration.h"
#include "datasets/imports/curve_files.h"
#include "datasets/store/external_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

namespace fs = std::filesystem;
using tests::TemporaryFolder;

const fs::path example = fs::path(GRAINTRUTH_SOURCE_DIR) / "examples/command";

TEST(Command, CalibratesTheExample) {
  if (!datasets::find_program("python3")) GTEST_SKIP() << "python3 is not installed";
  const TemporaryFolder folder;
  const datasets::Experiment experiment = datasets::load_experiment(example / "experiment.toml");
  std::vector<datasets::Recording> recordings;
  for (const datasets::Replicate& replicate : experiment.replicates)
    recordings.push_back({.curves = datasets::read_curves(replicate.curves, 0.0)});
  const Problem problem = make_problem(experiment, recordings, engine_named("command"));
  Journal journal(":memory:");
  const std::array experiments = {CalibratedExperiment{"ball", &problem}};
  CalibrationOptions options = default_options(experiments);
  options.budget = 20;
  options.search_seeds = 2;
  options.gate_seeds = 1;
  options.confirmation_seeds = 2;
  const EngineOptions engine_options{.scratch = folder / "scratch", .folder = example};
  const CalibrationResult result = calibrate(
      experiment, experiments, journal, *make_executor("threads", 2), engine_options, options);
  const auto found =
      std::find_if(result.calibrated.begin(), result.calibrated.end(), [](const auto& parameter) {
        return parameter.name == "rolling_friction_particle_wall";
      });
  ASSERT_NE(found, result.calibrated.end());
  const CalibratedParameter& friction = *found;
  EXPECT_NEAR(friction.value, 0.06, 0.003);
  ASSERT_TRUE(friction.interval);
  EXPECT_LT(friction.interval->lower, 0.06);
  EXPECT_GT(friction.interval->upper, 0.06);
  EXPECT_FALSE(fs::exists(folder / "scratch")) << "what the runs needed is left behind";
}

}  // namespace
}  // namespace graintruth::calibrate
