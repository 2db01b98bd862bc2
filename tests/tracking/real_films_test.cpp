// Recordings of other laboratories, tracked from the files in datasets/real as users do, where the
// recordings lie beside the repository. Limits: what the product asks; bench_real_recordings tells
// how far they are from being reached.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "datasets/store/table.h"
#include "tests/tracking/drawn_film.h"
#include "tracking/median.h"

namespace graintruth::tracking {
namespace {

const std::filesystem::path recordings =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/real-data";

TrackedFilm track_real(const char* file) {
  const datasets::Experiment experiment = datasets::load_experiment(
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/real" / file,
      datasets::Purpose::tracking);
  const datasets::Replicate& replicate = experiment.replicates.front();
  return track(datasets::make_tracking_spec(experiment, replicate),
               datasets::film_of(experiment, replicate));
}

// Rods marked by hand to 2 to 4 px; the scale is 9.23 px/mm, the origin (178.5, 479.5).
TEST(RealFilms, OfRodsLieWhereTheyWereMarked) {
  const std::filesystem::path folder = recordings / "magdeburg-rods";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const TrackedFilm film = track_real("magdeburg_rods.toml");
  const datasets::Trajectories& tracks = film.trajectories;
  const datasets::Table marks = datasets::read_csv(folder / "reference_rods_gp3.csv");
  ASSERT_EQ(tracks.frames(), 20U);
  std::vector<double> centres, angles;
  for (std::size_t row = 0; row < marks.rows(); ++row) {
    const Eigen::Vector2d from(marks.number(row, "x1_gp3"), marks.number(row, "y1_gp3"));
    const Eigen::Vector2d to(marks.number(row, "x2_gp3"), marks.number(row, "y2_gp3"));
    const auto frame = static_cast<std::size_t>(marks.integer(row, "frame") - 500);
    double nearest = 12.0, turned = 0.0;  // px; a sixth of a usual rod is the same rod
    for (std::size_t p = 0; p < static_cast<std::size_t>(tracks.particles); ++p) {
      const datasets::Pose& pose = tracks.poses[tracks.index(frame, p)];
      const Eigen::Vector2d at(178.5 + 9230.0 * pose.x, 479.5 - 9230.0 * pose.z);
      const double off = (at - 0.5 * (from + to)).norm();
      if (!(off < nearest)) continue;
      nearest = off;
      turned = std::remainder(pose.angle - std::atan2(from.y() - to.y(), to.x() - from.x()),
                              std::numbers::pi);
    }
    if (nearest == 12.0) continue;
    centres.push_back(nearest);
    angles.push_back(std::abs(turned) * 180.0 / std::numbers::pi);
  }
  EXPECT_GT(static_cast<double>(centres.size()), 0.85 * static_cast<double>(marks.rows()));
  EXPECT_LT(median(centres), 3.0);
  EXPECT_LT(median(angles), 2.0);
}

TEST(RealFilms, OfDiscsLoseNone) {
  if (!std::filesystem::exists(recordings / "lund-magnetic-discs")) GTEST_SKIP() << "not here";
  const TrackedFilm film = track_real("lund_discs_20.toml");
  EXPECT_EQ(film.trajectories.particles, 20);
  EXPECT_GT(film.summary.completeness, 0.999);
  EXPECT_EQ(film.summary.suspected_swaps, 0);
  EXPECT_TRUE(tells(film.summary, "time stamps are uneven"));
}

TEST(RealFilms, OfSpheresUnderAMicroscopeLoseNone) {
  if (!std::filesystem::exists(recordings / "trackpy-brightfield-foam")) GTEST_SKIP() << "not here";
  const TrackedFilm film = track_real("brightfield_spheres.toml");
  EXPECT_EQ(film.trajectories.particles, 5);
  EXPECT_EQ(film.summary.completeness, 1.0);
}

}  // namespace
}  // namespace graintruth::tracking
