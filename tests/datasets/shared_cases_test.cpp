// Inputs that failed once, which stand beside the repository; skipped where they do not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/track_files.h"
#include "datasets/scene/geometry_files.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {
namespace {

const std::filesystem::path source = GRAINTRUTH_SOURCE_DIR;

class SharedCases : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(cases_)) GTEST_SKIP() << cases_ << " is not there";
  }

  // Tracks of a case lie where the bundled truth has its particles, to this (m).
  static void expect_truth(const ReadTracks& read, int replicate, double tolerance) {
    const Table truth =
        read_csv(source / fmt::format("datasets/micro/truth/rep{}_tracks.csv", replicate));
    std::map<int, std::vector<std::array<double, 2>>> places;  // by frame of the 50 Hz film
    for (std::size_t row = 0; row < truth.rows(); ++row) {
      const int frame = static_cast<int>(std::lround(truth.number(row, "time_s") * 50.0));
      places[frame].push_back({truth.number(row, "x_m"), truth.number(row, "z_m")});
    }
    const Trajectories& tracks = read.tracks;
    ASSERT_EQ(tracks.particles, 10);
    ASSERT_EQ(tracks.frames(), 90U);
    double worst = 0.0;
    for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
      EXPECT_NEAR(tracks.time[frame], 0.02 * static_cast<double>(frame) - 0.2, 1e-9);
      for (std::size_t particle = 0; particle < 10; ++particle) {
        const Pose& pose = tracks.poses[tracks.index(frame, particle)];
        double nearest = INFINITY;
        for (const auto& [x, z] : places[static_cast<int>(frame)])
          nearest = std::min(nearest, std::hypot(pose.x - x, pose.z - z));
        worst = std::max(worst, nearest);
      }
    }
    EXPECT_LT(worst, tolerance);
  }

  const std::filesystem::path cases_ = source / "../shared/cases";
};

TEST_F(SharedCases, TrackMateTablesOfAGermanExcel) {
  for (int n = 1; n <= 3; ++n) {
    const auto read = read_track_file(cases_ / fmt::format("fail-06/rep{}.csv", n),
                                      {.origin = std::array{0.160, 0.124}, .event_time = 0.2});
    expect_truth(read, n, 1e-9);
  }
}

TEST_F(SharedCases, WholePixelsWithCommasBetweenThousands) {
  for (int n = 1; n <= 3; ++n) {
    // The scale and the origin of its experiment.toml; half a pixel is 0.07 mm
    const auto read = read_track_file(cases_ / fmt::format("fail-07/rep{}.txt", n),
                                      {.scale = 7500.0,
                                       .origin_px = std::array{1200.0, 930.0},
                                       .frame_rate = 50.0,
                                       .event_time = 0.2});
    expect_truth(read, n, 1e-4);
  }
}

// Its scale, origin and frame rate
const TrackSource trackpy_source{
    .scale = 2500.0, .origin_px = std::array{400.0, 310.0}, .frame_rate = 50.0, .event_time = 0.2};

TEST_F(SharedCases, TablesInUtf16) {
  for (int n = 1; n <= 3; ++n)
    expect_truth(
        read_track_file(cases_ / fmt::format("fail-12/rep{}.csv", n), trackpy_source), n, 1e-9);
  for (const char* name : {"narrow1", "narrow2", "wide1", "wide2"}) {
    EXPECT_GT(read_discharge_curve(
                  cases_ / "fail-12/cell" / (std::string(name) + ".csv"),
                  {.event_time = 0.5, .full_mass = 30 * 0.332e-3, .particle_mass = 0.332e-3})
                  .mass.back(),
              1e-3);
  }
  try {
    read_track_file(cases_ / "fail-12/book1.csv", trackpy_source);
    FAIL() << "a workbook was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("Excel workbook (.xlsx)"), std::string::npos);
  }
}

TEST_F(SharedCases, AnEmptyColumnZ) {
  for (int n = 1; n <= 3; ++n)
    expect_truth(
        read_track_file(cases_ / fmt::format("fail-15/rep{}.csv", n), trackpy_source), n, 1e-9);
}

TEST_F(SharedCases, AClockOfOneSecondAFrame) {
  TrackSource stated = trackpy_source;
  expect_truth(read_track_file(cases_ / "fail-11/rep1.xml", stated), 1, 1e-9);
  stated.frame_rate.reset();
  stated.usual_frame_rate = 50.0;
  try {
    read_track_file(cases_ / "fail-11/rep1.xml", stated);
    FAIL() << "a clock of 1 Hz was taken where 50 Hz are stated";
  } catch (const InputError& error) {
    for (const char* word : {"rep1.xml", "1 frames a second", "frame_rate_hz is 50"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST_F(SharedCases, HeadersThatDoNotStandInTheFirstLine) {
  const DischargeSource bin{
      .event_time = 0.5, .full_mass = 30 * 0.332e-3, .particle_mass = 0.332e-3};
  for (const char* kind : {"savetxt", "sep_line", "units_row"}) {
    for (const char* name : {"narrow1", "narrow2", "wide1", "wide2"}) {
      const auto file = cases_ / "fail-17" / kind / (std::string(name) + ".csv");
      EXPECT_GT(read_discharge_curve(file, bin).mass.back(), 1e-3) << file;
    }
  }
  // Its channel tells no unit
  try {
    read_discharge_curve(cases_ / "fail-17/lvm/narrow1.lvm", bin);
    FAIL() << "a weight without a unit was taken";
  } catch (const InputError& error) {
    for (const char* word :
         {"'Weight' has the name, but no unit", "line 20 was taken for the header"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST_F(SharedCases, MeshesOfOtherPrograms) {
  const auto text = read_stl(cases_ / "fail-08/text.stl", 1e-3).corners;
  for (const char* name : {"fail-13/upper", "fail-13/lead", "fail-13/bom"})
    EXPECT_EQ(read_stl(cases_ / (std::string(name) + ".stl"), 1e-3).corners, text);
  for (const char* name : {"fail-08/dup", "fail-08/dup_flip"}) {
    const Mesh mesh = read_stl(cases_ / (std::string(name) + ".stl"), 1e-3);
    EXPECT_EQ(mesh.corners, text);
    EXPECT_NE(mesh.note.find("2 facets with the same corners"), std::string::npos) << mesh.note;
  }
}

}  // namespace
}  // namespace graintruth::datasets
