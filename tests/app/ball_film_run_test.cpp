// A small calibration on drawn films of single balls, by the built program: every file that it
// leaves must do without angles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/app/laboratory.h"
#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"
#include "tracking/film/synthetic_video.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;

constexpr double frame_rate = 50.0;    // Hz
constexpr double onset = 0.2437;       // s of film
constexpr double piston_speed = 0.03;  // m/s, downwards
constexpr int frames = 40;

constexpr const char* experiment_text = R"(title = "Steel balls on a sinking piston"
[particle]
count = 5
mass_g = 4.1
spheres = [{offset_mm = 0, radius_mm = 5}]
[material]
elastic_modulus_mpa = 20
poisson_ratio = 0.3
friction_particle_particle = 0.2
friction_particle_wall = 0.2
restitution = 0.6
[rig]
kind = "walls"
front_back_gap_mm = 10.5
[rig.piston]
face_z_mm = 0
left_x_mm = -16
right_x_mm = 16
velocity_z_mm_per_s = -30
[[rig.wall]]
name = "left"
from_x_mm = -16
from_z_mm = -30
to_x_mm = -16
to_z_mm = 40
[[rig.wall]]
name = "right"
from_x_mm = 16
from_z_mm = -30
to_x_mm = 16
to_z_mm = 40
[camera]
frame_rate_hz = 50
fiducial_diameter_mm = 8
fiducials_mm = [[-30, -20], [-30, 5], [-30, 30], [30, -20], [30, 5], [30, 30]]
[[replicate]]
video = "film1.avi"
[[replicate]]
video = "film2.avi"
[[replicate]]
video = "film3.avi"
[measure]
frame_interval_s = 0.1
frames = 5
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.6}
)";

// Three balls on the piston and two in the hollows between them, a little elsewhere in each film.
std::vector<tracking::BodyPose> poses_at(int frame, unsigned film) {
  const double sunk = -piston_speed * std::max(0.0, frame / frame_rate - onset);
  const double off = 1.0e-4 * film;
  std::vector<tracking::BodyPose> poses;
  for (const double x : {-0.0105, 0.0, 0.0105}) poses.push_back({x + off, 0.005 + sunk, 0.0});
  const double height = 0.005 + std::sqrt(0.01 * 0.01 - 0.00525 * 0.00525);
  for (const double x : {-0.00525, 0.00525}) poses.push_back({x + off, height + sunk, 0.0});
  return poses;
}

// `shown` says which moment each picture shows.
void write_film_of_balls(
    const TemporaryFolder& folder,
    const datasets::Experiment& experiment,
    unsigned film,
    const std::function<int(int)>& shown = [](int k) { return k; },
    int count = frames) {
  tracking::SyntheticScene scene;
  scene.spec = datasets::make_tracking_spec(experiment, experiment.replicates.front());
  scene.camera = tracking::make_camera(394, 374, 0.001, 0.004, 0.6, 4800.0, -0.1, 0.0);
  scene.paints = {{0.8F, 0.8F, 0.8F}};
  scene.ground = 0.06F;
  scene.seed = film;
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < count; ++k) {
    const double face = -piston_speed * std::max(0.0, shown(k) / frame_rate - onset);
    pictures.push_back(tracking::draw_frame(scene, poses_at(shown(k), film), face, k));
  }
  tracking::write_film(folder / ("film" + std::to_string(film) + ".avi"), pictures, frame_rate);
}

TEST(BallFilmRun, LeavesOutWhatBallsDoNotShow) {
  const TemporaryFolder folder;
  const std::string file = folder.write("experiment.toml", experiment_text);
  for (const unsigned film : {1U, 2U, 3U})
    folder.write("film" + std::to_string(film) + ".avi", "");  // to be found when the file is read
  const datasets::Experiment experiment = datasets::load_experiment(file);
  for (const unsigned film : {1U, 2U, 3U}) write_film_of_balls(folder, experiment, film);
  const ProgramOutcome outcome = run_program(
      {"calibrate", file, "--budget", "20", "--out", folder / "out", "--jobs", "2", "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;

  // 1. Tracks: every ball in every frame, no angle
  const auto rows = read_rows(folder / "out/tracks/film1.csv");
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(frames * 5));
  for (const Row& row : rows) EXPECT_EQ(row.at("angle_rad"), "");
  const Json film = Json::parse(content_of(folder / "out/tracking.json"))["replicates"][0];
  EXPECT_EQ(film["completeness"], 1.0);
  EXPECT_FALSE(film.contains("angle_sigma_deg"));

  // 2. Scores: of x and z
  const Json result = Json::parse(content_of(folder / "out/result.json"));
  const Json& agreement = result["agreement"];
  EXPECT_EQ(agreement["quantities"], Json({"x", "z"}));
  for (const Json& particle : agreement["per_particle"]) {
    EXPECT_EQ(particle["rank3"], 0);
    const double possible = particle["possible"];
    EXPECT_EQ(possible, 10.0);
    EXPECT_NEAR(particle["percent"], 100.0 * particle["points"].get<double>() / possible, 1e-9);
  }

  // 3. A film beside its simulation, on one clock
  const Json beside = Json::parse(content_of(folder / "out/side_by_side.json"));
  const Json& stills = beside["stills"];
  ASSERT_EQ(stills.size(), 11U);  // 0.4 s at 25 pictures a second
  EXPECT_NEAR(stills.front()["time_s"], 0.0, 1.0 / frame_rate);
  EXPECT_GT(stills.back()["time_s"], stills.front()["time_s"]);
  cv::VideoCapture side_by_side((folder / "out/side_by_side.mp4").string());
  cv::Mat picture;
  ASSERT_TRUE(side_by_side.read(picture));
  EXPECT_EQ(picture.cols, 2 * 394);
  EXPECT_EQ(picture.rows, 374);
  // Where the left half shows a ball, the right half, which is bare otherwise, shows one too
  const cv::Mat last = cv::imread((folder / "out" / stills.back()["file"]).string());
  const cv::Mat right = last.colRange(394, 788);
  cv::Scalar mean, deviation;
  cv::meanStdDev(right, mean, deviation);
  EXPECT_GT(cv::norm(deviation), 20.0);

  // 4. The page draws no angles, and no file has what is not a number
  const std::string page = content_of(folder / "out/report.html");
  EXPECT_EQ(page.find("angle (°)"), std::string::npos);
  EXPECT_EQ(page.find("x, z and angle"), std::string::npos);
  for (const char* name : {"result.json", "measured.json", "tracking.json", "run.json"}) {
    const std::string text = content_of(folder / (std::string("out/") + name));
    EXPECT_EQ(text.find("NaN"), std::string::npos) << name;
    EXPECT_EQ(text.find("nan"), std::string::npos) << name;
  }
}

// Films on which nothing ever moves, though a time was noted.
TEST(BallFilmRun, IsNotCalibratedWhereTheTrackingFailedUnlessAskedFor) {
  const TemporaryFolder folder;
  std::string text =
      with(experiment_text, "frame_rate_hz = 50", "frame_rate_hz = 50\nnoted_event_s = 0.1");
  const std::string file = folder.write("experiment.toml", with(text, "frames = 5", "frames = 2"));
  for (const unsigned film : {1U, 2U, 3U}) folder.write("film" + std::to_string(film) + ".avi", "");
  const datasets::Experiment experiment = datasets::load_experiment(file);
  for (const unsigned film : {1U, 2U, 3U})
    write_film_of_balls(
        folder, experiment, film, [](int) { return 0; }, 16);
  std::vector<std::string> command = {
      "calibrate", file, "--budget", "20", "--out", folder / "out", "--jobs", "2", "--quiet"};
  const ProgramOutcome refused = run_program(command);
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  for (const char* words :
       {"the tracking has failed of film1 (The start of motion could not be found",
        "of film3 (",
        "--use-failed-tracks"})
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out/result.json"));
  const Json film = Json::parse(content_of(folder / "out/tracking.json"))["replicates"][0];
  EXPECT_EQ(film["grade"], "fail");
  EXPECT_EQ(film["failures"].size(), 1U);

  command.emplace_back("--use-failed-tracks");
  const ProgramOutcome asked_for = run_program(command);
  EXPECT_EQ(asked_for.status, 0) << asked_for.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "out/result.json"));
}

}  // namespace
}  // namespace graintruth::tests
