#include <gtest/gtest.h>

#include <cmath>

#include "datasets/imports/track_files.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

// Two particles in uniform motion, seen every 0.02 s from -0.1 s on; the second is hidden in
// frame 3.
Trajectories uniform_motion() {
  Trajectories tracks = make_trajectories(20, 2, true);
  for (std::size_t frame = 0; frame < 20; ++frame) {
    const double time = 0.02 * static_cast<double>(frame) - 0.1;
    tracks.time[frame] = time;
    tracks.poses[tracks.index(frame, 0)] = {0.1 + 0.5 * time, -0.2 * time, 1.0 + 3.0 * time};
    if (frame != 3) tracks.poses[tracks.index(frame, 1)] = {0.3, 0.4, 0.5};
    tracks.sigmas[tracks.index(frame, 0)] = {1e-4, 2e-4, 1e-3};
    tracks.sigmas[tracks.index(frame, 1)] = {1e-4, 2e-4, 1e-3};
  }
  return tracks;
}

TEST(Sample, IsExactForUniformMotionAtAnyTime) {
  const Trajectories sampled = sample(uniform_motion(), {-0.1, 0.0, 0.013, 0.28});
  for (std::size_t frame = 0; frame < sampled.frames(); ++frame) {
    const Pose& pose = sampled.poses[sampled.index(frame, 0)];
    EXPECT_NEAR(pose.x, 0.1 + 0.5 * sampled.time[frame], 1e-15);
    EXPECT_NEAR(pose.angle, 1.0 + 3.0 * sampled.time[frame], 1e-14);
  }
}

TEST(Sample, LeavesOutWhatOneOfTheTwoFramesDidNotSee) {
  const Trajectories sampled = sample(uniform_motion(), {-0.05, 0.01});
  EXPECT_TRUE(std::isnan(sampled.poses[sampled.index(0, 1)].x));
  EXPECT_EQ(sampled.poses[sampled.index(1, 1)].x, 0.3);
}

TEST(Sample, LeavesOutTimesThatTheRecordingDoesNotReach) {
  const Trajectories sampled = sample(uniform_motion(), {-0.2, 0.5});
  EXPECT_TRUE(std::isnan(sampled.poses[sampled.index(0, 0)].x));
  EXPECT_TRUE(std::isnan(sampled.poses[sampled.index(1, 0)].x));
}

TEST(Tracks, ReadBackToTheSameBits) {
  const TemporaryFolder folder;
  const Trajectories written = uniform_motion();
  write_tracks(folder / "a.csv", written);
  const Trajectories read = read_tracks(folder / "a.csv");
  ASSERT_EQ(read.frames(), written.frames());
  EXPECT_EQ(read.time, written.time);
  for (std::size_t i = 0; i < written.poses.size(); ++i) {
    if (std::isnan(written.poses[i].x)) {
      EXPECT_TRUE(std::isnan(read.poses[i].x));
      continue;
    }
    EXPECT_EQ(read.poses[i].x, written.poses[i].x);
    EXPECT_EQ(read.poses[i].angle, written.poses[i].angle);
    EXPECT_EQ(read.sigmas[i].z, written.sigmas[i].z);
  }
}

TEST(Tracks, AnglesWrittenWithinHalfATurnBecomeContinuous) {
  const TemporaryFolder folder;
  const Trajectories read =
      read_tracks(folder.write("a.csv",
                               "time_s,particle,x_m,z_m,angle_rad\n0,1,0,0,3.1\n0.1,1,0,0,0.1\n0.2,"
                               "1,0,0,0.3\n0.3,1,0,0,3.0\n"));
  EXPECT_NEAR(read.poses[1].angle, 0.1 + 3.14159265358979, 1e-9);
  EXPECT_NEAR(read.poses[2].angle, 0.3 + 3.14159265358979, 1e-9);
  EXPECT_NEAR(read.poses[3].angle, 3.0, 1e-12);
}

TEST(Tracks, UnusableFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_tracks(folder.write("a.csv", "time_s,particle,x_m,angle_rad\n0,1,0,0\n")),
               InputError);
  EXPECT_THROW(read_tracks(folder.write("b.csv", "time_s,particle,x_m,z_m,angle_rad\n")),
               InputError);
  EXPECT_THROW(read_tracks(folder.write("c.csv", "time_s,particle,x_m,z_m,angle_rad\n0,0,0,0,0\n")),
               InputError);
  EXPECT_THROW(
      read_tracks(folder.write("d.csv", "time_s,particle,x_m,z_m,angle_rad\n0,1.5,0,0,0\n")),
      InputError);
  EXPECT_THROW(
      read_tracks(folder.write("e.csv", "time_s,particle,x_m,z_m,angle_rad\n0,1,zero,0,0\n")),
      InputError);
  EXPECT_THROW(read_tracks(folder.write("f.csv", "time_s,particle,x_m,z_m,angle_rad\n,1,0,0,0\n")),
               InputError);
}

}  // namespace
}  // namespace graintruth::datasets
