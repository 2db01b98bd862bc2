// A tube of grains that is lifted off a plate, from its experiment file to the outline of the heap.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "calibrate/engines/embedded.h"
#include "calibrate/engines/scene_run.h"
#include "calibrate/problem.h"
#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "tests/calibrate/standing_grains.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using Changes = std::initializer_list<std::pair<std::string, std::string>>;

// The template of `graintruth new`, with text changed.
std::string heap(Changes changes = {}) {
  std::ifstream file(GRAINTRUTH_SOURCE_DIR "/app/new/lifted_cylinder/experiment.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  for (const auto& [from, to] : changes) {
    const auto place = text.find(from);
    if (place == std::string::npos) throw std::logic_error(from);
    text.replace(place, from.size(), to);
  }
  return text;
}

// So few grains that a heap takes a second to compute.
std::string small_heap() {
  return heap({{"count = 400", "count = 60"},
               {"tube_inner_diameter_mm = 34", "tube_inner_diameter_mm = 22"},
               {"lift_speed_mm_per_s = 40", "lift_speed_mm_per_s = 150"}});
}

class LiftedCylinder : public testing::Test {
 protected:
  LiftedCylinder() {
    for (const char* name : {"heap1.outline.csv", "heap2.outline.csv", "heap3.outline.csv"})
      folder_.write(name, "time_s,column_m,height_m\n1,0,0.01\n1,0.002,0.009\n");
  }

  datasets::Experiment load(const std::string& text) {
    return datasets::load_experiment(folder_.write("experiment.toml", text));
  }

  SimulationSpec spec_of(const datasets::Experiment& experiment) {
    std::vector<datasets::Recording> recordings(experiment.replicates.size());
    for (datasets::Recording& one : recordings) {
      one.outlines = {datasets::Outline{.column = {0.0, 0.002},
                                        .time = {1.0},
                                        .height = {0.01, 0.009},
                                        .sigma = {},
                                        .eye = {.x = 0.0, .z = 0.05, .distance = 0.5}}};
    }
    const Problem problem = plan_problem(experiment, recordings);
    return problem.spec_of(0, datasets::bench_parameters(experiment), 0.5, 1);
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

TEST_F(LiftedCylinder, LeavesAHeapWhoseOutlineIsThatOfItsGrains) {
  const datasets::Experiment experiment = load(small_heap());
  const SimulationSpec spec = spec_of(experiment);
  ASSERT_EQ(spec.record.outlines.size(), 1U);
  EXPECT_EQ(spec.record.outlines.front().eye.distance, 0.5);
  const EngineRun run = embedded_engine().run(spec, {});
  ASSERT_EQ(run.status, RunStatus::completed) << run.message;
  const datasets::Outline& outline = run.recording.outlines.front();
  const std::size_t last = outline.time.size() - 1;
  ASSERT_EQ(outline.height.size(), outline.time.size() * outline.column.size());
  // In the tube the grains stand about 16 mm high and 22 mm wide; then they lie lower, and wider
  const auto seen = [&](std::size_t moment) {
    double highest = 0.0, width = 0.0;
    for (std::size_t i = 0; i < outline.column.size(); ++i) {
      const double z = outline.height[outline.index(moment, i)];
      if (std::isnan(z)) continue;
      highest = std::max(highest, z);
      width += outline.column[1] - outline.column[0];
    }
    return std::pair(highest, width);
  };
  EXPECT_EQ(outline.time.front(), 0.0);
  EXPECT_NEAR(seen(0).second, 0.022, 0.0025);
  EXPECT_LT(seen(last).first, 0.8 * seen(0).first);
  EXPECT_GT(seen(last).first, 0.004);
  EXPECT_GT(seen(last).second, 1.3 * seen(0).second);
}

TEST_F(LiftedCylinder, LeavesNoColumnOfGrainsStanding) {
  const datasets::Experiment experiment = load(small_heap());
  datasets::SceneFile file;
  static_cast<datasets::SceneData&>(file) = spec_of(experiment).scene;
  EXPECT_EQ(standing_grains(run_scene(file, {}), experiment.particle.diameter), 0);
  // What this looks for is there where the lattice is perfect
  file.fill.jitter.reset();
  EXPECT_GT(standing_grains(run_scene(file, {}), experiment.particle.diameter), 10);
}

TEST_F(LiftedCylinder, SurfacesOfTubeAndPlateAreItsOwn) {
  const datasets::Experiment experiment =
      load(heap({{"restitution = 0.79", "restitution = 0.79\nfriction_particle_tube = 0.2"}}));
  const SimulationSpec spec = spec_of(experiment);
  const auto friction_on = [&](const char* name) {
    return datasets::parameter_named(std::string("friction_particle_") + name)
        .kind->value_in(name, spec.scene)
        .value();
  };
  EXPECT_EQ(friction_on("tube"), 0.2);
  EXPECT_EQ(friction_on("plate"), 0.35);
}

TEST_F(LiftedCylinder, IsFilledByNumberMassOrLevel) {
  EXPECT_EQ(load(heap()).particle.count, 400);
  EXPECT_EQ(load(heap({{"count = 400", ""}, {"# filled_mass_g = 33.2", "filled_mass_g = 8.31"}}))
                .particle.count,
            100);
  // 60 % of a cylinder of 34 mm and 20 mm height, in balls of 4 mm
  EXPECT_NEAR(
      load(heap({{"count = 400", ""}, {"# filled_height_mm = 25", "filled_height_mm = 20"}}))
          .particle.count,
      0.6 * 17.0 * 17.0 * 20.0 / (4.0 / 3.0 * 8.0),
      1.0);
}

TEST_F(LiftedCylinder, ThatCannotBeIsRefusedInOneSentence) {
  const auto expect_refusal = [&](Changes changes, std::vector<std::string> parts) {
    const std::string said = complaint(heap(changes));
    for (const std::string& part : parts) EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  expect_refusal({{"count = 400", ""}}, {"'rig.filled_mass_g'", "particle.count"});
  expect_refusal({{"# filled_mass_g = 33.2", "filled_mass_g = 33.2"}},
                 {"'rig.filled_mass_g'", "says already"});
  expect_refusal({{"tube_height_mm = 60", "tube_height_mm = 20"}},
                 {"'rig.tube_height_mm'", "400 grains stand about"});
  expect_refusal({{"tube_inner_diameter_mm = 34", "tube_inner_diameter_mm = 4"}},
                 {"'rig.tube_inner_diameter_mm'", "no grain of 4 mm has room"});
  expect_refusal({{"tube_wall_mm = 1.5", "tube_wall_mm = 3"}}, {"'rig.tube_wall_mm'", "rim"});
  expect_refusal({{"lift_speed_mm_per_s = 40\n", ""}}, {"lift_speed", "is missing"});
  expect_refusal({{"event_s = 0", "event_s = 0\neye_mm = [0, 40, 0]"}},
                 {"'replicate.eye_mm'", "above 0"});
}

}  // namespace
}  // namespace graintruth::calibrate
