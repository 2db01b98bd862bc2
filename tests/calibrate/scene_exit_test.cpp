// What happens to grains of a scene as a rig once they have left it.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "calibrate/engines/scene_run.h"
#include "calibrate/problem.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

std::string template_file(const std::string& name) {
  std::ifstream file(std::string(GRAINTRUTH_SOURCE_DIR "/app/new/scene/") + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The template of `graintruth new`: a box with a gate, here with few balls and a long run.
class SceneExit : public testing::Test {
 protected:
  Problem problem_with(const std::string& more_walls) {
    std::string box = template_file("box.toml");
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"count = 200", "count = 40"},
                                   {"duration_s = 1.0", "duration_s = 1.4"}})
      box.replace(box.find(from), from.size(), to);
    folder_.write("box.toml", box + more_walls);
    for (const char* cell : {"cell1.csv", "cell2.csv", "cell3.csv"}) folder_.write(cell, "");
    experiment_ = datasets::load_experiment(
        folder_.write("experiment.toml", template_file("experiment.toml")));
    complete_particle(experiment_);
    return plan_problem(experiment_, std::vector<datasets::Recording>(3));
  }

  tests::TemporaryFolder folder_;
  datasets::Experiment experiment_;
};

// After 1.2 s of free fall a ball would move more than a tenth of its radius in a step.
TEST_F(SceneExit, GrainsThatFallFreelyEndNoSimulationHoweverLong) {
  const Problem problem = problem_with("");
  const EngineRun run = problem.engine->run(
      problem.spec_of(
          0, datasets::bench_parameters(experiment_), problem.largest_time_step_fraction(), 1),
      {});
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  const std::vector<double>& left = run.recording.discharge->mass;
  EXPECT_GT(left.back(), 0.5 * 40 * experiment_.particle.mass);
  EXPECT_TRUE(std::is_sorted(left.begin(), left.end()));
}

TEST_F(SceneExit, GrainsThatFallOntoAnythingAreKept) {
  EXPECT_TRUE(problem_with("").scenes.front().spec.scene.leaves_below.has_value());
  const Problem problem = problem_with(R"(
[[wall]]
name = "pan"
material = "wall"
shape = "polygon"
corners_mm = [[-80, -50, -60], [80, -50, -60], [80, 50, -60], [-80, 50, -60]]
)");
  EXPECT_FALSE(problem.scenes.front().spec.scene.leaves_below.has_value());
}

// Grains of several sizes that rain in: each leaves with its own mass, as in `simulate`.
TEST(RainOfSizes, LeavesWithTheMassOfEverySize) {
  const tests::TemporaryFolder folder;
  std::string box = template_file("box.toml");
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"count = 200", "count = 30"},
        {"density_g_per_cm3 = 1.2",
         "density_g_per_cm3 = 1.2\nsize = {distribution = \"uniform\", standard_deviation = 0.2}"},
        {"elastic_modulus_mpa = 5 ", "elastic_modulus_mpa = 50 "},
        {"duration_s = 1.0", "duration_s = 0.3"}})
    box.replace(box.find(from), from.size(), to);
  const auto fill = box.find("[fill]"), after = box.find("\n[", fill);
  box.replace(fill,
              after - fill,
              "[fill]\nmethod = \"rain\"\nlow_mm = [-50, -25, 0]\nhigh_mm = [50, 25, 150]\n"
              "interval_s = 0.01\n");
  datasets::SceneFile scene = datasets::load_scene(folder.write("box.toml", box));
  for (datasets::ScenePhase& phase : scene.phases) {
    phase.fastest_impact = 3.0;
    phase.time_step_fraction = 0.2;
  }
  const SceneRun whole = run_scene(scene, {.seed = 5});
  SimulationSpec spec;
  spec.scene = scene;
  spec.seed = 5;
  spec.time_step_fraction = 0.2;
  const EngineRun run = engine_named("embedded").run(spec, {});
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  EXPECT_GT(run.recording.discharge->mass.back(), 0.0);
  EXPECT_NEAR(run.recording.discharge->mass.back(), whole.frames.back().bed.discharged_mass, 1e-12);
}

}  // namespace
}  // namespace graintruth::calibrate
