// Drawn films with known truth, whole pipeline. Positions are compared with the drawn midpoints.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <thread>

#include "tests/tracking/drawn_film.h"

namespace graintruth::tracking {
namespace {

constexpr double onset = 0.2437;  // s of film, between two frames
constexpr double speed = -0.046;
constexpr int frames = 45;

// Four bodies in a column over a piston, eight dots beside it.
SyntheticScene make_scene() {
  SyntheticScene scene;
  datasets::TrackingSpec& spec = scene.spec;
  spec.body = {"balls", {{-0.0139, 0.0222}, {0.0139, 0.0222}}, {}, 4};
  spec.rig.walls = {{"left", -0.085, -0.12, -0.085, 0.2}, {"right", 0.085, -0.12, 0.085, 0.2}};
  spec.rig.face = datasets::MovingFace{-0.03, -0.085, 0.085, speed};
  spec.camera.frame_rate = frame_rate;
  for (const double x : {-0.2, 0.2})
    for (const double z : {-0.1, -0.02, 0.07, 0.15}) spec.camera.fiducials.push_back({x, z, 0.014});
  spec.starts = {
      {-0.045, -0.0076, 0.02}, {0.043, -0.0074, 3.1}, {-0.03, 0.05, 1.1}, {0.04, 0.055, 2.3}};
  scene.camera = make_camera(448, 336, 0.004, 0.02, 1.5, 950.0, -0.2, 0.01);
  scene.paints = {
      {0.1F, 0.1F, 0.7F}, {0.1F, 0.65F, 0.8F}, {0.6F, 0.2F, 0.15F}, {0.06F, 0.06F, 0.06F}};
  return scene;
}

double sunk(int frame) { return speed * std::max(0.0, frame / frame_rate - onset); }

// All sink with the piston; the upper two turn and slide a little as well.
std::vector<BodyPose> poses_at(const SyntheticScene& scene, int frame) {
  std::vector<BodyPose> poses;
  const double since = std::max(0.0, frame / frame_rate - onset);
  for (std::size_t body = 0; body < scene.spec.starts.size(); ++body) {
    const auto& start = scene.spec.starts[body];
    BodyPose pose{start.x + 0.0002, start.z, start.angle};
    pose.z += sunk(frame);
    if (body == 2) pose.angle += 0.3 * since;
    if (body == 3) pose.x += 0.01 * since;
    poses.push_back(pose);
  }
  return poses;
}

std::vector<cv::Mat> draw(const SyntheticScene& scene, int count = frames) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < count; ++k)
    pictures.push_back(
        draw_frame(scene, poses_at(scene, k), scene.spec.rig.face->face_z + sunk(k), k));
  return pictures;
}

// The same drawn film serves all tests that only read it.
const std::vector<cv::Mat>& film() {
  static const std::vector<cv::Mat> pictures = draw(make_scene());
  return pictures;
}

struct Errors {
  double position_px = 0.0;  // rms per axis
  double angle = 0.0;        // rad, rms
  double normalised = 0.0;   // rms of error over sigma, x and z
  int seen = 0;
};

Errors errors_of(const SyntheticScene& scene, const datasets::Trajectories& tracks) {
  Errors errors;
  for (std::size_t k = 0; k < tracks.frames(); ++k) {
    const std::vector<BodyPose> truth = poses_at(scene, static_cast<int>(k));
    for (std::size_t body = 0; body < truth.size(); ++body) {
      const std::size_t i = tracks.index(k, body);
      if (!std::isfinite(tracks.poses[i].x)) continue;
      const double x = tracks.poses[i].x - truth[body].x, z = tracks.poses[i].z - truth[body].z;
      errors.position_px += x * x + z * z;
      errors.normalised +=
          std::pow(x / tracks.sigmas[i].x, 2) + std::pow(z / tracks.sigmas[i].z, 2);
      errors.angle +=
          std::pow(std::remainder(tracks.poses[i].angle - truth[body].angle, std::numbers::pi), 2);
      ++errors.seen;
    }
  }
  errors.position_px =
      std::sqrt(errors.position_px / (2.0 * errors.seen)) * scene.camera.scale(0.0, 0.0);
  errors.normalised = std::sqrt(errors.normalised / (2.0 * errors.seen));
  errors.angle = std::sqrt(errors.angle / errors.seen);
  return errors;
}

TEST(BallPairs, FindsEveryBodyToAFractionOfAPixel) {
  const SyntheticScene scene = make_scene();
  const auto [tracks, summary] = track(scene.spec, film());
  EXPECT_EQ(summary.frames_read, frames);
  EXPECT_EQ(summary.completeness, 1.0);
  const Errors errors = errors_of(scene, tracks);
  EXPECT_LT(errors.position_px, 0.15);
  EXPECT_LT(errors.angle, 0.5 * std::numbers::pi / 180.0);
  // Twenty independent errors at most (they change slowly): the bounds are wider than for a long
  // film
  EXPECT_GT(errors.normalised, 0.3);
  EXPECT_LT(errors.normalised, 2.0);
  EXPECT_NEAR(summary.event_time_s, onset, 0.005);
  EXPECT_EQ(summary.event_source, "piston face");
  EXPECT_NEAR(tracks.time[0], -onset, 0.005);
  for (std::size_t body = 0; body < 4; ++body) {
    EXPECT_GE(tracks.poses[body].angle, 0.0);
    EXPECT_LT(tracks.poses[body].angle, std::numbers::pi);
  }
}

TEST(BallPairs, GivesTheSameBitsEveryTimeAndBesideOthers) {
  const SyntheticScene scene = make_scene();
  const DrawnFilm drawn(film());
  const TrackedFilm alone = track(scene.spec, drawn.film());
  TrackedFilm one, two;
  std::thread first([&] { one = track(scene.spec, drawn.film()); });
  std::thread second([&] { two = track(scene.spec, drawn.film()); });
  first.join();
  second.join();
  for (const TrackedFilm* other : {&one, &two}) {
    ASSERT_EQ(other->trajectories.poses.size(), alone.trajectories.poses.size());
    for (std::size_t i = 0; i < alone.trajectories.poses.size(); ++i) {
      EXPECT_EQ(other->trajectories.poses[i].x, alone.trajectories.poses[i].x);
      EXPECT_EQ(other->trajectories.poses[i].angle, alone.trajectories.poses[i].angle);
      EXPECT_EQ(other->trajectories.sigmas[i].z, alone.trajectories.sigmas[i].z);
    }
  }
}

TEST(BallPairs, DoesNotCareAboutBrightness) {
  for (const double light : {0.8, 1.2}) {
    SyntheticScene scene = make_scene();
    scene.light = light;
    const auto [tracks, summary] = track(scene.spec, draw(scene));
    const Errors errors = errors_of(scene, tracks);
    EXPECT_EQ(summary.completeness, 1.0) << light;
    EXPECT_LT(errors.position_px, 0.17) << light;
  }
}

TEST(BallPairs, FollowsAShiftOfHalfAPixel) {
  SyntheticScene scene = make_scene();
  scene.camera = make_camera(448, 336, 0.004 + 0.5 / 950.0, 0.02, 1.5, 950.0, -0.2, 0.01);
  const auto [tracks, summary] = track(scene.spec, draw(scene));
  EXPECT_LT(errors_of(scene, tracks).position_px, 0.17);
}

TEST(BallPairs, SeesAMirroredFilmMirrored) {
  SyntheticScene scene = make_scene();
  std::vector<cv::Mat> mirrored;
  for (const cv::Mat& picture : film()) {
    cv::Mat turned(picture.size(), picture.type());
    for (int row = 0; row < picture.rows; ++row)
      for (int column = 0; column < picture.cols; ++column)
        turned.at<cv::Vec3b>(row, column) = picture.at<cv::Vec3b>(row, picture.cols - 1 - column);
    mirrored.push_back(turned);
  }
  datasets::TrackingSpec spec = scene.spec;
  for (auto& start : spec.starts) {
    start.x = -start.x;
    start.angle = std::numbers::pi - start.angle;
  }
  const auto [straight, first] = track(scene.spec, film());
  const auto [reversed, second] = track(spec, mirrored);
  for (std::size_t i = 0; i < straight.poses.size(); ++i) {
    EXPECT_NEAR(straight.poses[i].x, -reversed.poses[i].x, 0.2e-3);
    EXPECT_NEAR(straight.poses[i].z, reversed.poses[i].z, 0.2e-3);
  }
}

TEST(BallPairs, RefusesAFilmWithoutParticles) {
  SyntheticScene scene = make_scene();
  std::vector<cv::Mat> empty;
  for (int k = 0; k < 10; ++k) empty.push_back(draw_frame(scene, {}, -0.03, k));
  EXPECT_NE(refusal(scene.spec, empty).find("no particle"), std::string::npos);
}

TEST(BallPairs, RefusesAFilmWithoutFiducials) {
  const SyntheticScene scene = make_scene();
  const std::vector<cv::Mat> grey(5, cv::Mat(336, 448, CV_8UC3, cv::Scalar(90, 90, 90)));
  EXPECT_NE(refusal(scene.spec, grey).find("fiducials"), std::string::npos);
}

TEST(BallPairs, RefusesThreeFiducials) {
  SyntheticScene scene = make_scene();
  scene.spec.camera.fiducials.resize(3);
  EXPECT_NE(refusal(scene.spec, film()).find("4"), std::string::npos);
}

TEST(BallPairs, TellsOfAWrongCount) {
  datasets::TrackingSpec spec = make_scene().spec;
  spec.starts.clear();
  spec.body.count = 6;
  const TrackingSummary more = track(spec, film()).summary;
  EXPECT_EQ(more.grade, Grade::fail);
  EXPECT_TRUE(tells(more, "4 particles"));
  spec.body.count = 3;
  EXPECT_TRUE(tells(track(spec, film()).summary, "more than the 3"));
}

TEST(BallPairs, TellsOfAWrongSize) {
  for (const double factor : {0.92, 0.95, 1.05, 1.08}) {
    datasets::TrackingSpec spec = make_scene().spec;
    for (auto& sphere : spec.body.balls) {
      sphere.radius *= factor;
      sphere.offset *= factor;
    }
    const TrackingSummary summary = track(spec, film()).summary;
    EXPECT_TRUE(tells(summary, "radius")) << factor;
    EXPECT_EQ(summary.completeness, 1.0) << factor;
  }
}

TEST(BallPairs, TellsWhenTheNotedEventIsAnother) {
  datasets::TrackingSpec spec = make_scene().spec;
  spec.camera.noted_event_time = 0.24;
  EXPECT_FALSE(tells(track(spec, film()).summary, "noted"));
  spec.camera.noted_event_time = 0.5;
  EXPECT_TRUE(tells(track(spec, film()).summary, "noted"));
}

TEST(BallPairs, RefusesAFilmThatShowsNoStart) {
  const SyntheticScene scene = make_scene();
  EXPECT_NE(refusal(scene.spec, std::vector<cv::Mat>(film().begin(), film().begin() + 10))
                .find("start of motion"),
            std::string::npos);
}

TEST(BallPairs, DrawsWhatItFound) {
  const SyntheticScene scene = make_scene();
  const DrawnFilm drawn(film());
  TrackingOptions options;
  options.overlay_file = temporary("overlay.mp4");
  options.annotated_first = temporary("first.jpg");
  options.annotated_last = temporary("last.jpg");
  track(scene.spec, drawn.film(), options);
  for (const auto& product :
       {options.overlay_file, options.annotated_first, options.annotated_last}) {
    EXPECT_TRUE(std::filesystem::exists(product)) << product;
    std::filesystem::remove(product);
  }
}

}  // namespace
}  // namespace graintruth::tracking
