// The bundled heap: its tables are read, and its truth explains them better than other frictions.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::tests {
namespace {

class BundledHeap : public testing::Test {
 protected:
  double objective_at(const std::string& name, const std::string& parameters) {
    const ProgramOutcome outcome = run_program({"evaluate",
                                                heap_ + "experiment.toml",
                                                "--parameters",
                                                parameters,
                                                "--runs",
                                                "3",
                                                "--jobs",
                                                "2",
                                                "--out",
                                                folder_ / name,
                                                "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["objective"].get<double>();
  }

  const std::string heap_ = GRAINTRUTH_SOURCE_DIR "/datasets/heap/";
  TemporaryFolder folder_;
};

// A heap of grains that rub and roll as little as the bounds allow is far flatter.
TEST_F(BundledHeap, IsExplainedByItsTruth) {
  const std::string smooth =
      folder_.write("smooth.toml",
                    "friction_particle_particle = 0.1\nrolling_friction_particle_particle = 0.0\n");
  const double at_truth = objective_at("truth", heap_ + "truth.toml");
  // Where simulations are repeats of the replicates z has a standard deviation below 1
  EXPECT_LT(at_truth, 0.2);
  EXPECT_GT(objective_at("smooth", smooth), 5.0 * at_truth);
}

}  // namespace
}  // namespace graintruth::tests
