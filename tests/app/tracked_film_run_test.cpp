// Films without a rig, tracked by the built program from files of a few lines.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/app/laboratory.h"
#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"
#include "tests/tracking/drawn_shapes.h"
#include "tracking/film/synthetic_video.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;

constexpr int frames = 10, discs = 4;

constexpr const char* film_text = R"([particle]
body = "disc"
diameter_mm = 10

[camera]
frame_rate_hz = 50
[camera.stick]
from_px = [20, 120]
to_px = [220, 120]
length_mm = 100

[[replicate]]
video = "film.avi"
)";

Eigen::Vector2d place_of(int disc, int frame) {
  return {40.0 + 50.0 * disc + 1.5 * frame, 60.0 + 30.0 * disc - 0.5 * frame};
}

class TrackedFilmRun : public testing::Test {
 protected:
  TrackedFilmRun() {
    std::vector<cv::Mat> pictures;
    for (int frame = 0; frame < frames; ++frame) {
      tracking::Canvas canvas(256, 240, cv::Scalar::all(110));
      for (int disc = 0; disc < discs; ++disc)
        canvas.ellipse(place_of(disc, frame), 10.0, 10.0, 0.0, cv::Scalar(40, 60 + 40 * disc, 220));
      pictures.push_back(canvas.picture(2.0, static_cast<unsigned>(frame)));
    }
    tracking::write_film(folder_ / "film.avi", pictures, 50.0);
  }

  ProgramOutcome run(const std::string& verb, const std::string& text) {
    const std::string file = folder_.write("film.toml", text);
    std::vector<std::string> command = {verb, file, "--out", folder_ / "out"};
    if (verb != "check") command.emplace_back("--quiet");
    return run_program(command);
  }
  Json film() const {
    return Json::parse(content_of(folder_ / "out/tracking.json"))["replicates"][0];
  }

  TemporaryFolder folder_;
};

TEST_F(TrackedFilmRun, GivesTracksAndSaysWhatAStickAssumes) {
  const ProgramOutcome outcome = run("track", film_text);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = read_rows(folder_ / "out/tracks/film.csv");
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(frames * discs));
  for (const Row& row : rows) {
    // Numbered by rows from below; two pixels a millimetre from the stick's left end
    const int disc = discs - static_cast<int>(number(row, "particle"));
    const Eigen::Vector2d at = place_of(disc, static_cast<int>(number(row, "frame")));
    EXPECT_NEAR(number(row, "x_m"), (at.x() - 20.0) / 2000.0, 0.1e-3);
    EXPECT_NEAR(number(row, "z_m"), (120.0 - at.y()) / 2000.0, 0.1e-3);
    EXPECT_EQ(row.at("angle_rad"), "");
    EXPECT_GT(number(row, "sigma_x_m"), 0.0);
  }
  const Json summary = film();
  EXPECT_EQ(summary["scale_from"], "1 stick");
  EXPECT_TRUE(summary["calibration_rms_mm"].is_null());
  EXPECT_FALSE(summary.contains("angle_sigma_deg"));
  EXPECT_EQ(summary["event_source"], "first frame of the film");
  ASSERT_EQ(summary["warnings"].size(), 1U);
  EXPECT_NE(summary["warnings"][0].get<std::string>().find("Nothing on the film measures it"),
            std::string::npos);
  EXPECT_NE(outcome.out.find("Nothing on the film measures it"), std::string::npos) << outcome.out;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/tracks/film.overlay.mp4"));
  EXPECT_EQ(summary["annotated_frames"].size(), 3U);
  EXPECT_EQ(Json::parse(
                content_of(folder_ / "out/run.json"))["configuration"]["camera"]["stick"]["length"],
            0.1);
}

// What was tracked before is read back, unless something that decides it was edited.
TEST_F(TrackedFilmRun, IsDoneOnceForEveryStateOfItsFile) {
  ASSERT_EQ(run("track", film_text).status, 0);
  const Json before = film();
  ASSERT_EQ(run("track", "title = \"Another title\"\n" + std::string(film_text)).status, 0);
  EXPECT_EQ(film(), before);
  ASSERT_EQ(run("track", with(film_text, "length_mm = 100", "length_mm = 200")).status, 0);
  EXPECT_NE(film()["hash"], before["hash"]);
  EXPECT_NEAR(
      film()["scale_px_per_mm"].get<double>(), 0.5 * before["scale_px_per_mm"].get<double>(), 1e-9);
}

// What is kept of a film is used as it was left, or not at all, and that is said.
TEST_F(TrackedFilmRun, IsTrackedAgainWhereAFileOfItWasChanged) {
  const std::string file = folder_.write("film.toml", film_text);
  const auto track = [&] {
    const ProgramOutcome outcome = run_program({"track", file, "--out", folder_ / "out"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  const std::string again = "Note: film is tracked again: ";
  EXPECT_EQ(track().find(again), std::string::npos);
  const std::filesystem::path tracks = folder_ / "out/tracks/film.csv",
                              record = folder_ / "out/tracks/film.json";
  const std::string kept = content_of(tracks);
  EXPECT_EQ(track().find(again), std::string::npos);

  const std::string known = content_of(record);
  Json earlier = Json::parse(known);
  earlier.erase("files");
  earlier.erase("checksum");
  const auto changed = [&](const std::filesystem::path& place, const std::string& content) {
    std::ofstream(place, std::ios::binary) << content;
    return track();
  };
  struct Fault {
    std::filesystem::path place;
    std::string content, words;
  };
  const std::string edited = "tracks/film.csv was changed after it was written";
  for (const Fault& fault :
       std::vector<Fault>{{tracks, kept.substr(0, kept.size() / 2), edited},
                          {tracks, kept.substr(0, kept.rfind('\n', kept.size() - 2) + 1), edited},
                          {tracks, with(kept, ",1,", ",2,"), edited},
                          {tracks, "", edited},
                          {record,
                           with(known, "\"grade\": \"warn\"", "\"grade\": \"ok\""),
                           "its record was changed after it was written"},
                          {record, known.substr(0, known.size() / 2), "its record is cut off"},
                          {record, "[]", "its record is cut off or holds something else"},
                          {record, earlier.dump(), "it was tracked by an earlier version"}}) {
    const std::string said = changed(fault.place, fault.content);
    EXPECT_NE(said.find(again + fault.words), std::string::npos) << said;
    EXPECT_EQ(content_of(tracks), kept) << fault.words;
    EXPECT_EQ(film()["grade"], "warn");
  }
  std::filesystem::remove(tracks);
  EXPECT_NE(track().find(again + "tracks/film.csv is gone"), std::string::npos);
  EXPECT_EQ(content_of(tracks), kept);
  folder_.write("film.toml", with(film_text, "length_mm = 100", "length_mm = 200"));
  EXPECT_NE(track().find(again + "the film, its corrections or what is said of it have changed"),
            std::string::npos);
  EXPECT_NE(content_of(tracks), kept);
}

// The same pictures kept one by one, with four clicked points for a scale.
TEST_F(TrackedFilmRun, TakesPicturesAndClickedPoints) {
  std::filesystem::create_directory(folder_ / "pictures");
  cv::VideoCapture capture((folder_ / "film.avi").string());
  cv::Mat picture;
  for (int frame = 0; capture.read(picture); ++frame)
    cv::imwrite(folder_ / ("pictures/" + std::to_string(frame) + ".png"), picture);
  std::string text = with(film_text, "video = \"film.avi\"", "video = \"pictures\"");
  const std::size_t from = text.find("[camera.stick]"), to = text.find("[[replicate]]");
  text.replace(from,
               to - from,
               "[[camera.point]]\npx = [20, 20]\nmm = [0, 100]\n"
               "[[camera.point]]\npx = [220, 20]\nmm = [100, 100]\n"
               "[[camera.point]]\npx = [220, 220]\nmm = [100, 0]\n"
               "[[camera.point]]\npx = [20, 220]\nmm = [0, 0]\n");
  const ProgramOutcome outcome = run("track", text);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = read_rows(folder_ / "out/tracks/pictures.csv");
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(frames * discs));
  EXPECT_NEAR(number(rows[0], "z_m"), (220.0 - place_of(3, 0).y()) / 2000.0, 0.1e-3);
  EXPECT_EQ(film()["scale_from"], "4 points");
  EXPECT_EQ(film()["points_used"], 4);
}

TEST_F(TrackedFilmRun, IsRefusedByThoseWhoCalibrate) {
  for (const char* verb : {"calibrate", "check"}) {
    const ProgramOutcome outcome = run(verb, film_text);
    EXPECT_EQ(outcome.status, 2) << verb;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find("film.toml:1: key 'title' is missing"), std::string::npos)
        << outcome.err;
  }
}

}  // namespace
}  // namespace graintruth::tests
