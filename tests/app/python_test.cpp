// import graintruth: the simulator, an evaluation, a run folder and the example notebook, from
// Python.
#include <gtest/gtest.h>

#include "tests/app/laboratory.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

TEST(Python, SimulatesEvaluatesAndReadsARunFolder) {
  const TemporaryFolder folder;
  write_tracks_of_truth(folder);
  folder.write("experiment.toml", track_experiment());
  // Where the notebook looks for the bundled experiment, this small one
  std::filesystem::create_directories(folder / "datasets");
  std::filesystem::create_directory_symlink(folder.path(), folder / "datasets/micro");
  const std::filesystem::path source = GRAINTRUTH_SOURCE_DIR;
  const ProgramOutcome outcome = run_program({"--chdir=" + folder.path().string(),
                                              "PYTHONPATH=" GRAINTRUTH_PYTHON_PATH,
                                              "PYTHONDONTWRITEBYTECODE=1",
                                              GRAINTRUTH_PYTHON,
                                              source / "tests/app/python_session.py",
                                              source / "examples/first_steps.ipynb"},
                                             "/usr/bin/env");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

}  // namespace
}  // namespace graintruth::tests
