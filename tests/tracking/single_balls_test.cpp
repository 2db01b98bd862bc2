// Drawn films of single balls with known truth: all of one colour, at rest, rolling, bouncing and
// in touch with each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/tracking/drawn_film.h"
#include "tracking/balls/ball_tracker.h"

namespace graintruth::tracking {
namespace {

constexpr double radius = 5.0e-3;    // m
constexpr double onset = 0.2437;     // s of film, between two frames
constexpr double speed = -0.0231;    // m/s, of the piston
constexpr double piston_z = -0.025;  // m, of its face at first
constexpr int frames = 45;
constexpr int covered_ball = 5, covered_first = 30, covered_last = 32;

struct Look {
  const char* name;
  double diameter_px;
  bool dark;  // steel before a white wall; or white balls before a dark one
  unsigned seed;
  double noise;  // grey levels
};

// What each ball does once the piston sinks. A film is long enough for all of it.
std::vector<BodyPose> poses_at(int frame) {
  const double since = std::max(0.0, frame / frame_rate - onset);
  const double sunk = speed * since;
  std::vector<BodyPose> poses;
  // 1. Four in touch on the piston; the outer ones roll away from the others
  for (int i = 0; i < 4; ++i) {
    const double away = i == 0 ? -0.008 * since : i == 3 ? 0.012 * since : 0.0;
    poses.push_back({(2 * i - 3) * radius + away, piston_z + radius + sunk, 0.0});
  }
  // 2. Three above them: the middle one stays in its hollow
  for (int i = 0; i < 3; ++i) {
    const double away = 0.018 * (i - 1) * since;
    poses.push_back(
        {(2 * i - 2) * radius + away, piston_z + (1.0 + std::sqrt(3.0)) * radius + sunk, 0.0});
  }
  // 3. One rolls into another of the same weight, which takes over its speed and comes back from
  // the wall
  constexpr double rolling = 0.11, gap = 0.03,
                   way = 0.0235;  // m/s; m between surfaces, to the wall
  const double hit = gap / rolling, wall = hit + way / rolling;
  poses.push_back({-0.04 + rolling * std::min(since, hit), 0.035, 0.0});
  const double rolled =
      rolling * (std::clamp(since - hit, 0.0, way / rolling) - 0.5 * std::max(0.0, since - wall));
  poses.push_back({-0.04 + gap + 2.0 * radius + rolled, 0.035, 0.0});
  // 4. One falls and bounces, each time 0.7 as fast
  double height = 0.010, up = 0.0, left = since;
  for (int bounce = 0; bounce < 12; ++bounce) {
    const double flight = (up + std::sqrt(up * up + 2.0 * 9.81 * height)) / 9.81;
    if (left < flight) break;
    left -= flight;
    up = 0.7 * (9.81 * flight - up);
    height = 0.0;
  }
  if (up > 0.05 || height > 0.0) height += up * left - 0.5 * 9.81 * left * left;
  poses.push_back({0.043, height, 0.0});
  return poses;
}

SyntheticScene make_scene(const Look& look) {
  SyntheticScene scene;
  datasets::TrackingSpec& spec = scene.spec;
  spec.body = {"balls", {{0.0, radius}}, {}, static_cast<int>(poses_at(0).size())};
  spec.rig.walls = {{"left", -0.055, -0.05, -0.055, 0.05}, {"right", 0.055, -0.05, 0.055, 0.05}};
  spec.rig.pane_gap = 0.0105;
  spec.rig.face = datasets::MovingFace{piston_z, -0.055, 0.055, speed};
  spec.camera.frame_rate = frame_rate;
  for (const double x : {-0.066, 0.066})
    for (const double z : {-0.042, -0.014, 0.014, 0.042})
      spec.camera.fiducials.push_back({x, z, 0.008});
  const double scale = look.diameter_px / (2.0 * radius);
  // Every film has its camera in another place. A little askew, as all are: a piston that lies
  // along the rows and sinks by two of them a frame would be taken for an interlaced film.
  const double shift = 0.0003 * look.seed;  // m
  scene.camera = make_camera(static_cast<int>(0.152 * scale),
                             static_cast<int>(0.104 * scale),
                             0.001 + shift,
                             -0.001 + shift,
                             0.6,
                             scale,
                             -0.1,
                             0.016 - 4.0 * shift);
  const float paint = look.dark ? 0.12F : 0.8F;
  scene.paints = {{paint, paint, paint}};
  scene.ground = look.dark ? 0.72F : 0.06F;
  scene.light_slope = 0.3;
  scene.noise = look.noise;
  scene.seed = look.seed;
  return scene;
}

// One ball is hidden for a moment, as by a finger.
std::vector<cv::Mat> draw(const SyntheticScene& scene, int count = frames) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < count; ++k) {
    const std::vector<BodyPose> poses = poses_at(k);
    const double sunk = speed * std::max(0.0, k / frame_rate - onset);
    pictures.push_back(draw_frame(scene, poses, piston_z + sunk, k));
    if (k < covered_first || k > covered_last) continue;
    const Eigen::Vector2d middle =
        scene.camera.project(poses[covered_ball].x, poses[covered_ball].z);
    const int reach = static_cast<int>(1.05 * radius * scene.camera.scale(0.0, 0.0));
    const cv::Rect finger(static_cast<int>(middle.x()) - reach,
                          static_cast<int>(middle.y()) - reach,
                          2 * reach + 1,
                          2 * reach + 1);
    pictures.back()(finger).setTo(cv::Scalar(110, 130, 180));
  }
  return pictures;
}

struct Errors {
  double position_px = 0.0;  // rms per axis
  double normalised = 0.0;   // rms of error over sigma, x and z
  int seen = 0, strangers = 0;
  bool has_angles = false;
};

Errors errors_of(const SyntheticScene& scene,
                 const std::vector<int>& places,
                 const datasets::Trajectories& tracks) {
  Errors errors;
  for (std::size_t k = 0; k < tracks.frames(); ++k) {
    const std::vector<BodyPose> truth = poses_at(static_cast<int>(k));
    for (std::size_t particle = 0; particle < places.size(); ++particle) {
      const std::size_t i = tracks.index(k, particle);
      const BodyPose& here = truth[static_cast<std::size_t>(places[particle])];
      errors.has_angles |=
          std::isfinite(tracks.poses[i].angle) || std::isfinite(tracks.sigmas[i].angle);
      if (!std::isfinite(tracks.poses[i].x)) continue;
      const double x = tracks.poses[i].x - here.x, z = tracks.poses[i].z - here.z;
      ++errors.seen;
      errors.strangers += std::hypot(x, z) > 0.5 * radius;
      errors.position_px += x * x + z * z;
      errors.normalised +=
          std::pow(x / tracks.sigmas[i].x, 2) + std::pow(z / tracks.sigmas[i].z, 2);
    }
  }
  errors.position_px =
      std::sqrt(errors.position_px / (2.0 * errors.seen)) * scene.camera.scale(0.0, 0.0);
  errors.normalised = std::sqrt(errors.normalised / (2.0 * errors.seen));
  return errors;
}

// Numbers by rows from below, left to right: which ball of poses_at has each.
const std::vector<int> by_rows = {0, 1, 2, 3, 4, 5, 6, 9, 7, 8};

const Look small{"bright, small", 25.0, false, 1, 2.0};

// Serves all tests that only read it. Long enough for the start of motion to be found.
const std::vector<cv::Mat>& short_film() {
  static const std::vector<cv::Mat> pictures = draw(make_scene(small), 28);
  return pictures;
}

TEST(SingleBalls, AreFollowedToAFractionOfAPixel) {
  double normalised_square = 0.0;
  const std::vector<Look> looks = {small,
                                   {"dark, small", 25.0, true, 2, 4.0},
                                   {"bright, large", 48.0, false, 3, 4.0},
                                   {"dark, large", 48.0, true, 4, 2.0}};
  for (const Look& look : looks) {
    SCOPED_TRACE(look.name);
    const SyntheticScene scene = make_scene(look);
    const auto [tracks, summary] = track(scene.spec, draw(scene));
    const Errors errors = errors_of(scene, by_rows, tracks);
    const int visible = frames * *scene.spec.body.count - (covered_last - covered_first + 1);
    EXPECT_EQ(errors.strangers, 0);
    EXPECT_GE(errors.seen, 0.995 * visible);
    EXPECT_LT(errors.position_px, 0.15);
    // The camera's error is one draw a film: a single one may look better or worse than it is.
    EXPECT_GT(errors.normalised, 0.4);
    EXPECT_LT(errors.normalised, 1.5);
    normalised_square += errors.normalised * errors.normalised / static_cast<double>(looks.size());
    EXPECT_FALSE(errors.has_angles);
    EXPECT_EQ(summary.suspected_swaps, 0);
    EXPECT_EQ(summary.angle_jumps, 0);
    EXPECT_NEAR(summary.event_time_s, onset, 0.005);
    EXPECT_EQ(summary.event_source, "piston face");
  }
  EXPECT_GT(std::sqrt(normalised_square), 0.75);
  EXPECT_LT(std::sqrt(normalised_square), 1.3);
}

TEST(SingleBalls, AreNumberedByTheirStartingPlaces) {
  datasets::TrackingSpec spec = make_scene(small).spec;
  const std::vector<int> wanted = {9, 8, 7, 6, 5, 4, 3, 2, 1, 0};
  for (const int ball : wanted) {
    const BodyPose pose = poses_at(0)[static_cast<std::size_t>(ball)];
    spec.starts.push_back({pose.x + 0.001, pose.z});
  }
  const TrackedFilm film = track(spec, short_film());
  EXPECT_EQ(errors_of(make_scene(small), wanted, film.trajectories).strangers, 0);
  EXPECT_EQ(film.summary.grade, Grade::ok);
}

TEST(SingleBalls, TellOfAWrongCount) {
  datasets::TrackingSpec spec = make_scene(small).spec;
  spec.body.count = 12;
  const TrackingSummary more = track(spec, short_film()).summary;
  EXPECT_EQ(more.grade, Grade::fail);
  EXPECT_TRUE(tells(more, "Frame 0 shows 10 particles but the experiment says 12."));
  spec.body.count = 9;
  EXPECT_TRUE(tells(track(spec, short_film()).summary, "more than the 9"));
}

TEST(SingleBalls, TellOfAWrongSize) {
  for (const double factor : {0.9, 0.95, 1.05, 1.1}) {
    SCOPED_TRACE(factor);
    datasets::TrackingSpec spec = make_scene(small).spec;
    spec.body.balls[0].radius *= factor;
    const DrawnFilm drawn(short_film());
    BallTracker tracker(spec, drawn.film());
    const TrackingSummary summary = track_film(tracker, spec, drawn.film()).summary;
    EXPECT_TRUE(tells(summary, "The balls look"));
    EXPECT_EQ(summary.completeness, 1.0);
    EXPECT_NEAR(tracker.learned().radius_mean, radius, 0.02 * radius);
  }
}

TEST(SingleBalls, AreMissedInAnEmptyFilm) {
  const SyntheticScene scene = make_scene(small);
  std::vector<cv::Mat> empty;
  for (int k = 0; k < 3; ++k) empty.push_back(draw_frame(scene, {}, piston_z, k));
  EXPECT_NE(refusal(scene.spec, empty).find("no particle of one ball"), std::string::npos);
}

TEST(SingleBalls, RowsOfThreeAreRefusedWithAWayOut) {
  datasets::TrackingSpec spec = make_scene(small).spec;
  spec.body.balls = {{-0.004, radius}, {0.0, radius}, {0.004, radius}};
  EXPECT_NE(refusal(spec, {cv::Mat(64, 64, CV_8UC3, cv::Scalar(9, 9, 9))}).find("imports.md"),
            std::string::npos);
}

}  // namespace
}  // namespace graintruth::tracking
