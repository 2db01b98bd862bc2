// Repairs by hand, of tracks of any kind of body.
#include "tracking/film/corrections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/temporary_folder.h"
#include "tests/tracking/drawn_film.h"
#include "tests/tracking/drawn_shapes.h"

namespace graintruth::tracking {
namespace {

TEST(Corrections, AreReplayedInOrder) {
  const tests::TemporaryFolder folder;
  datasets::Trajectories tracks = datasets::make_trajectories(3, 2, true);
  for (std::size_t k = 0; k < 3; ++k) {
    tracks.poses[tracks.index(k, 0)] = {1.0, 0.0, 0.0};
    tracks.poses[tracks.index(k, 1)] = {2.0, 0.0, 0.0};
  }
  const auto file = folder.write("repairs.csv",
                                 "frame,action,particle,other,x_m,z_m,angle_rad\n"
                                 "1,swap,1,2,,,\n"
                                 "0,move,2,,5,6,0.5\n"
                                 "2,delete,2,,,,\n");
  EXPECT_EQ(apply_corrections(file, 1.0e-3, true, tracks).size(), 3U);
  EXPECT_EQ(tracks.poses[tracks.index(0, 0)].x, 1.0);
  EXPECT_EQ(tracks.poses[tracks.index(1, 0)].x, 2.0);
  EXPECT_EQ(tracks.poses[tracks.index(2, 0)].x, 2.0);
  EXPECT_EQ(tracks.poses[tracks.index(0, 1)].z, 6.0);
  EXPECT_EQ(tracks.sigmas[tracks.index(0, 1)].x, 1.0e-3);
  EXPECT_EQ(tracks.poses[tracks.index(1, 1)].x, 1.0);
  EXPECT_TRUE(std::isnan(tracks.poses[tracks.index(2, 1)].x));
  const auto wrong = folder.write("wrong.csv", "frame,action,particle\n7,delete,1\n");
  EXPECT_THROW(apply_corrections(wrong, 1.0e-3, true, tracks), datasets::InputError);
}

// Tracks of two bodies in three frames.
datasets::Trajectories two_bodies(double angle) {
  datasets::Trajectories tracks = datasets::make_trajectories(3, 2, true);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t body = 0; body < 2; ++body)
      tracks.poses[tracks.index(k, body)] = {1.0 + static_cast<double>(body), 0.0, angle};
  return tracks;
}

std::string refusal_of(const std::string& rows, bool shows_angle) {
  const tests::TemporaryFolder folder;
  const auto file =
      folder.write("repairs.csv", "frame,action,particle,other,x_m,z_m,angle_rad\n" + rows);
  datasets::Trajectories tracks = two_bodies(shows_angle ? 0.0 : std::nan(""));
  try {
    apply_corrections(file, 1.0e-3, shows_angle, tracks);
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

// Discs, single balls, round plates.
TEST(Corrections, OfABodyWithoutAngleTakeNone) {
  const tests::TemporaryFolder folder;
  for (const char* rows : {"frame,action,particle,x_m,z_m\n1,move,2,5,6\n",
                           "frame,action,particle,x_m,z_m,angle_rad\n1,move,2,5,6,\n"}) {
    datasets::Trajectories tracks = two_bodies(std::nan(""));
    apply_corrections(folder.write("repairs.csv", rows), 1.0e-3, false, tracks);
    const std::size_t moved = tracks.index(1, 1);
    EXPECT_EQ(tracks.poses[moved].x, 5.0);
    EXPECT_EQ(tracks.poses[moved].z, 6.0);
    EXPECT_TRUE(std::isnan(tracks.poses[moved].angle));
    EXPECT_TRUE(std::isnan(tracks.sigmas[moved].angle));
    EXPECT_EQ(tracks.sigmas[moved].x, 1.0e-3);
  }
  EXPECT_NE(refusal_of("1,move,2,,5,6,0.3\n", false).find("shows no angle"), std::string::npos);
  EXPECT_NE(refusal_of("1,move,2,,5,6,\n", true).find("'move' needs angle_rad"), std::string::npos);
}

TEST(Corrections, AreRefusedWithFileAndLine) {
  const std::string said = refusal_of("0,swap,1,2,,,\n1,turn,2,,,,\n", true);
  EXPECT_NE(said.find("repairs.csv:3: action 'turn' is unknown"), std::string::npos) << said;
}

// A hand states an angle within half a turn; the track may have turned further.
TEST(Corrections, LeaveAnglesContinuous) {
  const tests::TemporaryFolder folder;
  constexpr double pi = std::numbers::pi;
  datasets::Trajectories tracks = two_bodies(2.0 * pi + 0.2);
  const auto file =
      folder.write("repairs.csv", "frame,action,particle,x_m,z_m,angle_rad\n1,move,1,5,6,0.3\n");
  apply_corrections(file, 1.0e-3, true, tracks);
  EXPECT_NEAR(tracks.poses[tracks.index(1, 0)].angle, 2.0 * pi + 0.3, 1e-12);
  EXPECT_EQ(tracks.poses[tracks.index(2, 0)].angle, 2.0 * pi + 0.2);
}

// --- Drawn films of every kind of body that is located picture by picture ----------------------

struct Kind {
  datasets::SeenBody body;
  double major, minor;  // px, half axes of what is drawn
  bool shows_angle;
};

constexpr double pixels_per_metre = 2000.0;
constexpr int frames = 8;

Eigen::Vector2d place_of(int body, int frame) {
  return {60.0 + 90.0 * body + 1.2 * frame, 120.0 - 40.0 * body + 0.7 * frame};
}

std::vector<cv::Mat> film_of(const Kind& kind) {
  std::vector<cv::Mat> pictures;
  for (int frame = 0; frame < frames; ++frame) {
    Canvas canvas(220, 180, cv::Scalar::all(kind.body.kind == "disc" ? 120 : 222));
    for (int body = 0; body < 2; ++body) {
      const cv::Scalar colour = body == 0 ? cv::Scalar(40, 50, 200) : cv::Scalar(190, 90, 40);
      if (kind.body.kind == "rod") {
        canvas.bar(place_of(body, frame), 2.0 * kind.major, 2.0 * kind.minor, 0.4, colour);
      } else {
        canvas.ellipse(place_of(body, frame), kind.major, kind.minor, 0.4, colour);
      }
    }
    pictures.push_back(canvas.picture(2.0, static_cast<unsigned>(frame)));
  }
  return pictures;
}

void expect_every_repair(const Kind& kind) {
  datasets::TrackingSpec spec;
  spec.body = kind.body;
  spec.camera.frame_rate = frame_rate;
  spec.camera.stick = datasets::Stick{{10.0, 90.0}, {210.0, 90.0}, 0.1, 0.0, {10.0, 90.0}};
  spec.camera.click_error = 0.02;
  const DrawnFilm drawn(film_of(kind));
  const TrackedFilm plain = track(spec, drawn.film());
  ASSERT_EQ(plain.trajectories.particles, 2);
  ASSERT_EQ(plain.summary.shows_angle, kind.shows_angle);

  const tests::TemporaryFolder folder;
  datasets::Film film = drawn.film();
  film.corrections = folder.write("repairs.csv",
                                  "frame,action,particle,other,x_m,z_m,angle_rad\n"
                                  "2,move,1,,0.04,0.02," +
                                      std::string(kind.shows_angle ? "0.5" : "") +
                                      "\n"
                                      "4,swap,1,2,,,\n"
                                      "6,delete,2,,,,\n");
  const TrackedFilm repaired = track(spec, film);
  const datasets::Trajectories &before = plain.trajectories, &after = repaired.trajectories;
  for (std::size_t k = 0; k < frames; ++k) {
    const datasets::Pose& first = after.poses[after.index(k, 0)];
    const datasets::Pose& second = after.poses[after.index(k, 1)];
    if (k == 2) {
      EXPECT_EQ(first.x, 0.04);
      EXPECT_EQ(first.z, 0.02);
      EXPECT_EQ(std::isfinite(first.angle), kind.shows_angle);
      EXPECT_NEAR(after.sigmas[after.index(k, 0)].x, 1.0 / pixels_per_metre, 1e-6);
    } else {
      EXPECT_EQ(first.x, before.poses[before.index(k, k < 4 ? 0 : 1)].x) << k;
    }
    if (k < 6)
      EXPECT_EQ(second.x, before.poses[before.index(k, k < 4 ? 1 : 0)].x) << k;
    else
      EXPECT_TRUE(std::isnan(second.x)) << k;
  }
  EXPECT_TRUE(tells(repaired.summary, "Corrected by hand: move particle 1 from frame 2."));
  EXPECT_TRUE(tells(repaired.summary, "Corrected by hand: delete particle 2 from frame 6."));
}

constexpr double metres(double pixels) { return pixels / pixels_per_metre; }

TEST(Corrections, OfAFilmOfDiscs) {
  expect_every_repair({{"disc", {}, {{"diameter", metres(24.0)}}, {}}, 12.0, 12.0, false});
}

TEST(Corrections, OfAFilmOfRods) {
  expect_every_repair(
      {{"rod", {}, {{"length", metres(60.0)}, {"diameter", metres(10.0)}}, {}}, 30.0, 5.0, true});
}

TEST(Corrections, OfAFilmOfPlates) {
  expect_every_repair(
      {{"plate",
        {},
        {{"semi_major", metres(20.0)}, {"semi_minor", metres(13.0)}, {"thickness", 2.0e-3}},
        {}},
       20.0,
       13.0,
       true});
}

}  // namespace
}  // namespace graintruth::tracking
