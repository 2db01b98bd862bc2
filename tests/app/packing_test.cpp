// How densely buttons pack: loosely with friction, densely without (thesis 4.3.2.1).
#include <gtest/gtest.h>

#include "calibrate/engines/scene_run.h"
#include "tests/app/laboratory.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::app {
namespace {

using tests::with;

// Mean height of 80 buttons of the macro bin, softened to settle fast, above its floor, m.
double mean_height(const std::string& friction, std::uint64_t seed) {
  const tests::TemporaryFolder folder;
  std::string text = tests::content_of(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) /
                                       "datasets/scenes/macro_bin.toml");
  text = with(text, "elastic_modulus_mpa = 35", "elastic_modulus_mpa = 3.5");
  text = with(text, "count = 200", "count = 80");
  text = with(text, "[settle]\nfriction = 0.2", "[settle]\nfriction = " + friction);
  text = with(text, "longest_s = 2.0", "longest_s = 4.0");
  text = with(text, "duration_s = 1.5", "duration_s = 0.001");
  const calibrate::SceneRun run =
      calibrate::run_scene(datasets::load_scene(folder.write("scene.toml", text)), {.seed = seed});
  EXPECT_TRUE(run.phases.front().came_to_rest);
  double height = 0.0;
  for (const sim::Body& body : run.scene.bodies) height += body.position.z() / 80.0;
  return height;
}

TEST(Packing, WithoutFrictionIsDenser) {
  for (const std::uint64_t seed : {1, 2}) {
    const double loose = mean_height("0.2", seed), dense = mean_height("0.0", seed);
    // 0.79 against 0.84 of the thesis is 6 %
    EXPECT_LT(dense, 0.97 * loose);
    EXPECT_GT(dense, 0.80 * loose);
  }
}

}  // namespace
}  // namespace graintruth::app
