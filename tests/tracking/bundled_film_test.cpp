// One of the bundled films against its truth. Tolerances: the product's targets.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "datasets/table.h"
#include "tracking/track_video.h"

namespace graintruth::tracking {
namespace {

TEST(BundledFilm, IsTrackedAsItWas) {
  const std::filesystem::path folder =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/micro";
  const datasets::Experiment experiment = datasets::load_experiment(folder / "experiment.toml");
  const auto [tracks, summary] = track_video(experiment, experiment.replicates[1]);
  const datasets::Table truth =
      datasets::read_csv(folder / "truth" / (experiment.replicates[1].name + "_tracks.csv"));
  EXPECT_GE(summary.least_complete_particle, 0.995);
  EXPECT_NEAR(summary.event_time_s, 0.2, 0.005);
  double square = 0.0, angle_square = 0.0, normalised = 0.0;
  int count = 0, strangers = 0;
  for (std::size_t row = 0; row < truth.rows(); ++row) {
    const std::size_t i =
        tracks.index(static_cast<std::size_t>(truth.integer(row, "frame")),
                     static_cast<std::size_t>(truth.integer(row, "particle")) - 1);
    const datasets::Pose& seen = tracks.poses[i];
    if (!std::isfinite(seen.x)) continue;
    const double x = seen.x - truth.number(row, "x_m"), z = seen.z - truth.number(row, "z_m");
    const double angle =
        std::remainder(seen.angle - truth.number(row, "angle_rad"), std::numbers::pi);
    square += x * x + z * z;
    angle_square += angle * angle;
    normalised += x * x / (tracks.sigmas[i].x * tracks.sigmas[i].x) +
                  z * z / (tracks.sigmas[i].z * tracks.sigmas[i].z);
    strangers += std::hypot(x, z) > 0.01;  // somebody else: bodies are 30 mm apart or more
    ++count;
  }
  EXPECT_EQ(strangers, 0);
  EXPECT_EQ(summary.angle_jumps, 0);
  EXPECT_EQ(summary.suspected_swaps, 0);
  // The product's limit, even against the centre of mass, which real particles have up to 0.2 mm off
  // the midpoint.
  EXPECT_LT(std::sqrt(square / (2.0 * count)), 0.14e-3);
  EXPECT_LT(std::sqrt(angle_square / count), 0.3 * std::numbers::pi / 180.0);
  const double z_score = std::sqrt(normalised / (2.0 * count));
  EXPECT_GT(z_score, 0.75);
  EXPECT_LT(z_score, 1.3);
}

}  // namespace
}  // namespace graintruth::tracking
