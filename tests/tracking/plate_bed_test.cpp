// Drawn films of plates running out of a bin, with other sizes and colours than the bundled ones.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <opencv2/core.hpp>

#include "datasets/store/input_error.h"
#include "tests/tracking/drawn_film.h"
#include "tracking/plates/bed_tracker.h"
#include "tracking/plates/plate.h"

namespace graintruth::tracking {
namespace {

constexpr double bed_rate = 120.0;  // Hz
constexpr double opening = 0.05;    // s of film
constexpr int frames = 22;
constexpr double degree = std::numbers::pi / 180.0;

datasets::SeenBody plates(double semi_major, double semi_minor) {
  return {"plate",
          {},
          {{"semi_major", semi_major}, {"semi_minor", semi_minor}, {"thickness", 0.002}},
          30};
}

// Larger and longer than the bundled buttons, and dark on a light ground.
SyntheticBed make_bed() {
  SyntheticBed bed;
  datasets::TrackingSpec& spec = bed.scene.spec;
  spec.body = plates(0.010, 0.0065);
  spec.rig.box = datasets::OpenBox{0.14, 0.12, 0.06};
  spec.camera.frame_rate = bed_rate;
  for (const double x : {-0.095, 0.095})
    for (const double z : {-0.02, 0.03, 0.08, 0.115})
      spec.camera.fiducials.push_back({x, z, 0.008});
  bed.scene.camera = make_camera(440, 400, 0.0, 0.045, 1.1, 2000.0, -0.1, 0.01);
  bed.scene.paints = {{0.30F, 0.22F, 0.20F}, {0.18F, 0.30F, 0.22F}, {0.15F, 0.18F, 0.35F}};
  bed.ground = {0.8F, 0.8F, 0.78F};
  bed.bars = {0.45F, 0.5F, 0.5F};
  bed.scene.noise = 2.0;
  return bed;
}

// Five rows of six; those over the orifice fall freely once it opens and turn on their way. Angles
// differ from plate to plate; none overlaps another.
std::vector<datasets::Pose> poses_at(double time) {
  std::vector<datasets::Pose> poses;
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 6; ++column) {
      datasets::Pose pose{-0.055 + 0.022 * column,
                          0.0075 + 0.0165 * row,
                          (12.0 * ((3 * row + 5 * column) % 5 - 2)) * degree};
      const double falling = std::max(0.0, time - opening);
      if (std::abs(pose.x) < 0.025) {
        pose.z -= 0.5 * 9.81 * falling * falling;
        pose.angle += (column == 2 ? 3.0 : -2.0) * falling;
      }
      poses.push_back(pose);
    }
  }
  return poses;
}

// The same, but of the right one of the two falling columns an arch catches what is not yet
// through.
constexpr double coarse_rate = 50.0;  // Hz
std::vector<datasets::Pose> caught_at(double time) {
  constexpr double caught = opening + 0.09;
  std::vector<datasets::Pose> poses = poses_at(time);
  const std::vector<datasets::Pose> stopped = poses_at(caught);
  for (std::size_t p = 0; p < poses.size(); ++p)
    if (time > caught && poses[p].x > 0.0 && stopped[p].z > 0.005) poses[p] = stopped[p];
  return poses;
}

std::vector<cv::Mat> draw_film(int from = 0, int count = frames) {
  const SyntheticBed bed = make_bed();
  std::vector<cv::Mat> film;
  for (int k = from; k < from + count; ++k)
    film.push_back(draw_bed(bed, poses_at(k / bed_rate), k / bed_rate > opening, k));
  return film;
}

const std::vector<cv::Mat>& film() {
  static const std::vector<cv::Mat> drawn = draw_film();
  return drawn;
}

struct TrackedBed {
  datasets::Trajectories trajectories;
  StagnantBed stagnant;
  TrackingSummary summary;
  BedSummary bed;
};

TrackedBed track(const datasets::TrackingSpec& spec,
                 const std::vector<cv::Mat>& pictures,
                 double rate = bed_rate) {
  const DrawnFilm drawn(pictures, rate);
  const datasets::TrackingSpec recorded = as_recorded(spec, drawn.film().video);
  BedTracker tracker(recorded, drawn.film());
  TrackedFilm film = track_film(tracker, recorded, drawn.film());
  return {std::move(film.trajectories), tracker.stagnant(), film.summary, tracker.bed()};
}

struct Errors {
  double position_px = 0.0, angle_deg = 0.0, normalised = 0.0;  // rms
  int seen = 0, strangers = 0;
};

Errors errors_of(const TrackedBed& tracked,
                 std::vector<datasets::Pose> (*true_poses)(double) = poses_at) {
  Errors errors;
  std::vector<int> identity(static_cast<std::size_t>(tracked.trajectories.particles), -1);
  for (std::size_t k = 0; k < tracked.trajectories.frames(); ++k) {
    const auto truth = true_poses(tracked.trajectories.time[k] + tracked.summary.event_time_s);
    for (std::size_t p = 0; p < identity.size(); ++p) {
      const datasets::Pose& seen = tracked.trajectories.poses[tracked.trajectories.index(k, p)];
      if (!std::isfinite(seen.x)) continue;
      int nearest = 0;
      double least = 1.0;
      for (std::size_t q = 0; q < truth.size(); ++q) {
        const double distance = std::hypot(truth[q].x - seen.x, truth[q].z - seen.z);
        if (distance < least) {
          least = distance;
          nearest = static_cast<int>(q);
        }
      }
      if (k == 0) identity[p] = nearest;
      ++errors.seen;
      errors.strangers += identity[p] != nearest;
      const datasets::Pose& real = truth[static_cast<std::size_t>(nearest)];
      const datasets::Pose& sigma = tracked.trajectories.sigmas[tracked.trajectories.index(k, p)];
      errors.position_px += least * least;
      errors.normalised +=
          std::pow((seen.x - real.x) / sigma.x, 2) + std::pow((seen.z - real.z) / sigma.z, 2);
      const double angle = std::remainder(seen.angle - real.angle, std::numbers::pi);
      errors.angle_deg += angle * angle;
    }
  }
  const double n = errors.seen;
  errors.position_px = std::sqrt(errors.position_px / (2.0 * n)) * 2000.0;
  errors.normalised = std::sqrt(errors.normalised / (2.0 * n));
  errors.angle_deg = std::sqrt(errors.angle_deg / n) / degree;
  return errors;
}

TEST(TouchingScale, OfPlatesInLineIsTheirDistanceOverTheirAxes) {
  const PlateShape shape{0.010, 0.006};
  // The search stops at a part in a million.
  EXPECT_NEAR(touching_scale({0, 0, 0}, {0.02, 0, 0}, shape), 1.0, 1e-6);
  EXPECT_NEAR(touching_scale({0, 0, 0}, {0, 0.006, 0}, shape), 0.5, 1e-6);
  // Side to tip: b + a
  EXPECT_NEAR(touching_scale({0, 0, std::numbers::pi / 2}, {0.016, 0, 0}, shape), 1.0, 1e-6);
}

TEST(PlateBed, FollowsEveryPlateOfADrawnDischarge) {
  const TrackedBed tracked = track(make_bed().scene.spec, film());
  EXPECT_EQ(tracked.bed.found_first, 30);
  EXPECT_EQ(tracked.bed.unaccounted, 0);
  EXPECT_EQ(tracked.bed.discharged + tracked.bed.remaining, 30);
  // Two columns of five fall; how many are through at the end is plain kinematics
  int through = 0;
  for (const datasets::Pose& pose : poses_at((frames - 1) / bed_rate)) through += pose.z < 0.0;
  EXPECT_EQ(tracked.bed.discharged, through);
  const Errors errors = errors_of(tracked);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.15);  // the product's limit
  EXPECT_LT(errors.angle_deg, 1.0);
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.6);
  // A fifth of a frame is what sets the opening apart from noise in the first drops
  EXPECT_NEAR(tracked.summary.event_time_s, opening, 0.5 / bed_rate);
  for (const std::string& sentence : tracked.summary.warnings) ADD_FAILURE() << sentence;
}

// Without marks they show no angle, and none is made up.
TEST(PlateBed, FollowsDiscs) {
  SyntheticBed bed = make_bed();
  bed.scene.spec.body = plates(0.0078, 0.0078);
  bed.holes = false;
  std::vector<cv::Mat> film;
  for (int k = 0; k < frames; ++k)
    film.push_back(draw_bed(bed, poses_at(k / bed_rate), k / bed_rate > opening, k));
  const TrackedBed tracked = track(bed.scene.spec, film);
  EXPECT_EQ(tracked.bed.found_first, 30);
  EXPECT_EQ(tracked.bed.unaccounted, 0);
  const Errors errors = errors_of(tracked);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.15);
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.6);
  for (const datasets::Pose& pose : tracked.trajectories.poses)
    EXPECT_FALSE(std::isfinite(pose.angle));
  for (const std::string& sentence : tracked.summary.warnings) ADD_FAILURE() << sentence;
}

TEST(PlateBed, TellsOfAWrongCount) {
  datasets::TrackingSpec spec = make_bed().scene.spec;
  spec.body.count = 32;
  const TrackingSummary summary = track(spec, film()).summary;
  EXPECT_EQ(summary.grade, Grade::fail);
  EXPECT_TRUE(tells(summary, "shows 30 particles but the experiment says 32"));
}

TEST(PlateBed, TellsOfAWrongSize) {
  for (const double factor : {0.9, 1.06}) {
    datasets::TrackingSpec spec = make_bed().scene.spec;
    spec.body.lengths["semi_major"] *= factor;
    spec.body.lengths["semi_minor"] *= factor;
    EXPECT_TRUE(tells(track(spec, film()).summary, "check the particle's size")) << factor;
  }
}

TEST(PlateBed, TellsOfAFilmThatStartsAfterTheOpening) {
  const auto late = draw_film(10, 12);
  const TrackingSummary summary = track(make_bed().scene.spec, late).summary;
  EXPECT_EQ(summary.grade, Grade::fail);
  EXPECT_TRUE(tells(summary, "starts after the orifice has opened"));
}

TEST(PlateBed, RefusesAFilmWithoutPlates) {
  const SyntheticBed bed = make_bed();
  std::vector<cv::Mat> empty;
  for (int k = 0; k < 8; ++k) empty.push_back(draw_bed(bed, {}, k > 4, k));
  try {
    track(bed.scene.spec, empty);
    FAIL() << "was tracked";
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("nothing leaves the bin"), std::string::npos)
        << error.what();
  }
}

TEST(PlateBed, TakesRepairsByHand) {
  const DrawnFilm drawn(film(), bed_rate);
  datasets::Film repaired = drawn.film();
  repaired.corrections = temporary("repairs.csv");
  std::ofstream(repaired.corrections) << "frame,action,particle,x_m,z_m,angle_rad\n"
                                         "3,move,2,0.01,0.02,0.4\n"
                                         "5,delete,2,,,\n";
  const TrackedFilm tracked = tracking::track(make_bed().scene.spec, repaired);
  std::filesystem::remove(repaired.corrections);
  const datasets::Trajectories& tracks = tracked.trajectories;
  EXPECT_EQ(tracks.poses[tracks.index(3, 1)].x, 0.01);
  EXPECT_EQ(tracks.poses[tracks.index(3, 1)].z, 0.02);
  EXPECT_NEAR(
      std::remainder(tracks.poses[tracks.index(3, 1)].angle - 0.4, std::numbers::pi), 0.0, 1e-12);
  EXPECT_TRUE(std::isfinite(tracks.poses[tracks.index(4, 1)].x));
  EXPECT_TRUE(std::isnan(tracks.poses[tracks.index(5, 1)].x));
}

TEST(PlateBed, TakesInterlacedFramesApart) {
  std::vector<cv::Mat> woven;
  for (int k = 0; k + 1 < frames; k += 2) {
    cv::Mat frame = film()[static_cast<std::size_t>(k)].clone();
    const cv::Mat& later = film()[static_cast<std::size_t>(k) + 1];
    for (int row = 1; row < frame.rows; row += 2) later.row(row).copyTo(frame.row(row));
    woven.push_back(frame);
  }
  datasets::TrackingSpec spec = make_bed().scene.spec;
  spec.camera.frame_rate = 0.5 * bed_rate;
  const TrackedBed tracked = track(spec, woven, 0.5 * bed_rate);
  EXPECT_EQ(tracked.bed.scan, "even rows first");
  EXPECT_EQ(tracked.trajectories.frames(), static_cast<std::size_t>(frames));
  const Errors errors = errors_of(tracked);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.2);
  EXPECT_TRUE(tells(tracked.summary, "interlaced"));
}

// Plates that fall by more than their pitch between frames and then stop at once look as if each
// had become the next one below. They share one colour, which cannot tell them apart.
TEST(PlateBed, TellsPlatesApartThatStopWithinTheirPitch) {
  SyntheticBed bed = make_bed();
  bed.scene.paints = {bed.scene.paints[0]};
  constexpr int coarse_frames = 11;
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < coarse_frames; ++k)
    pictures.push_back(draw_bed(bed, caught_at(k / coarse_rate), k / coarse_rate > opening, k));
  // The uppermost plate of that column: how much it falls from frame to frame
  const auto step = [](int k) {
    constexpr std::size_t uppermost = 4 * 6 + 3;
    return caught_at((k - 1) / coarse_rate)[uppermost].z - caught_at(k / coarse_rate)[uppermost].z;
  };
  ASSERT_GT(step(7) + 9.81 / (coarse_rate * coarse_rate), 0.0165);  // next: more than the pitch
  ASSERT_EQ(step(8), 0.0);
  datasets::TrackingSpec spec = bed.scene.spec;
  spec.camera.frame_rate = coarse_rate;
  const TrackedBed tracked = track(spec, pictures, coarse_rate);
  EXPECT_EQ(tracked.bed.found_first, 30);
  EXPECT_EQ(tracked.bed.unaccounted, 0);
  const Errors errors = errors_of(tracked, caught_at);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.15);
  int through = 0;
  for (const datasets::Pose& pose : caught_at((coarse_frames - 1) / coarse_rate))
    through += pose.z < 0.0;
  EXPECT_EQ(tracked.bed.discharged, through);
}

// The same discharge with the shutter open all the time, at a quarter of the rate.
TEST(PlateBed, MapsWhatStandsStillWherePlatesAreSmeared) {
  constexpr int exposures = 8, smeared_frames = 8;
  constexpr double slow_rate = 30.0, rest = 0.1;  // Hz; s of film before the opening
  const SyntheticBed bed = make_bed();
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < smeared_frames; ++k) {
    cv::Mat sum;
    for (int i = 0; i < exposures; ++i) {
      const double time = (k + (i + 0.5) / exposures) / slow_rate - rest + opening;
      cv::Mat one;
      draw_bed(bed, poses_at(time), time > opening, k).convertTo(one, CV_32FC3, 1.0 / exposures);
      sum = sum.empty() ? one : cv::Mat(sum + one);
    }
    sum.convertTo(pictures.emplace_back(), CV_8UC3);
  }
  datasets::TrackingSpec spec = bed.scene.spec;
  spec.camera.frame_rate = slow_rate;
  const TrackedBed tracked = track(spec, pictures, slow_rate);
  ASSERT_EQ(tracked.stagnant.maps.size(), static_cast<std::size_t>(smeared_frames));
  EXPECT_TRUE(tells(tracked.summary, "smeared"));
  const PlateShape plate = plate_shape(spec.body);
  const double diameter = 2.0 * std::sqrt(plate.semi_major * plate.semi_minor);
  // Four columns of five rows stand, two fall: in each frame and column beside the orifice the top
  // of the uppermost plate
  const double top = 0.0075 + 4 * 0.0165 + plate.semi_minor;
  int columns = 0;
  for (std::size_t i = 0; i < tracked.stagnant.x.size(); ++i) {
    // Between the two standing plates of a row nothing is seen to stand
    const double x = std::abs(tracked.stagnant.x[i]);
    if (std::abs(x - 0.055) > 0.5 * diameter && std::abs(x - 0.033) > 0.5 * diameter) continue;
    for (const std::vector<double>& heights : tracked.stagnant.height) {
      if (std::isnan(heights[i])) continue;
      EXPECT_NEAR(heights[i], top, 0.5 * diameter) << "at x = " << tracked.stagnant.x[i];
      ++columns;
    }
  }
  EXPECT_GT(columns, 4 * smeared_frames);
  // Over the orifice it moves once it has opened
  const datasets::StagnantMap& flowing = tracked.stagnant.maps[5];
  for (std::size_t i = 0; i < flowing.x.size(); ++i)
    for (std::size_t row = 0; row < flowing.z.size(); ++row)
      if (std::abs(flowing.x[i]) < 0.015) {
        EXPECT_NE(flowing.at(i, row), datasets::Ground::still)
            << flowing.x[i] << ' ' << flowing.z[row];
      }
  // The plates that stand are listed throughout, those that fall while they rest
  for (std::size_t p = 0; p < 30; ++p) {
    const datasets::Pose& first = tracked.trajectories.poses[tracked.trajectories.index(0, p)];
    ASSERT_TRUE(std::isfinite(first.x));
    const datasets::Pose& late = tracked.trajectories.poses[tracked.trajectories.index(6, p)];
    EXPECT_EQ(std::isfinite(late.x), std::abs(first.x) > 0.025) << first.x << ' ' << first.z;
  }
}

}  // namespace
}  // namespace graintruth::tracking
