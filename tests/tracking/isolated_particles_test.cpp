// Locators of particles that neither touch nor are packed, on drawn pictures whose truth is known,
// and on recordings of others where these lie beside the repository.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "datasets/store/input_error.h"
#include "datasets/store/table.h"
#include "tracking/bodies/linked_tracks.h"
#include "tracking/bodies/rods.h"
#include "tracking/bodies/spots.h"
#include "tracking/view/chessboard.h"

namespace graintruth::tracking {
namespace {

const std::filesystem::path recordings =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/real-data";

// Bright blurred discs on a ground that grows lighter, with noise.
cv::Mat drawn(const std::vector<Eigen::Vector2d>& places, double noise) {
  std::mt19937 random(3);
  std::normal_distribution<float> grain(0.0F, static_cast<float>(noise));
  cv::Mat picture(200, 300, CV_32F);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      double value = 40.0 + 0.1 * column;
      for (const Eigen::Vector2d& place : places)
        value +=
            120.0 * std::exp(-0.5 * (place - Eigen::Vector2d(column, row)).squaredNorm() / 4.0);
      picture.at<float>(row, column) = static_cast<float>(value) + grain(random);
    }
  }
  cv::Mat whole;
  picture.convertTo(whole, CV_8U);
  return whole;
}

std::vector<Eigen::Vector2d> lattice() {
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 40; ++i)
    places.emplace_back(20.0 + 28.37 * (i % 10), 20.0 + 45.21 * (i / 10));
  return places;
}

TEST(Spots, AreFoundToATenthOfAPixelAndNoOthers) {
  const std::vector<Eigen::Vector2d> places = lattice();
  const std::vector<Spot> spots = locate_spots(drawn(places, 3.0), {.diameter_px = 11});
  ASSERT_EQ(spots.size(), places.size());
  for (const Eigen::Vector2d& place : places) {
    double nearest = 1e9;
    for (const Spot& spot : spots) nearest = std::min(nearest, (spot.pixel - place).norm());
    EXPECT_LT(nearest, 0.2);
  }
}

TEST(Spots, MoveWithThePictureByAnyPartOfAPixel) {
  std::vector<Eigen::Vector2d> moved = lattice();
  for (Eigen::Vector2d& place : moved) place += Eigen::Vector2d(0.3, -0.4);
  const auto before = locate_spots(drawn(lattice(), 0.0), {.diameter_px = 11});
  const auto after = locate_spots(drawn(moved, 0.0), {.diameter_px = 11});
  ASSERT_EQ(before.size(), after.size());
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  for (const Spot& spot : before) {
    const auto nearest = std::min_element(after.begin(), after.end(), [&](auto& a, auto& b) {
      return (a.pixel - spot.pixel).norm() < (b.pixel - spot.pixel).norm();
    });
    step += (nearest->pixel - spot.pixel) / static_cast<double>(before.size());
  }
  EXPECT_NEAR(step.x(), 0.3, 0.03);
  EXPECT_NEAR(step.y(), -0.4, 0.03);
}

TEST(Spots, AreNotInventedOnAnEmptyGround) {
  EXPECT_TRUE(locate_spots(drawn({}, 0.0), {.diameter_px = 11, .least_mass = 50.0}).empty());
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Two that pass each other, one of them unseen for a while; lengths in pixels
TEST(TrackLinker, FollowsMotionThroughAGap) {
  const auto tracks_of = [](int memory) {
    TrackLinker linker({.reach = 12.0, .lever = 5.0, .memory = memory});
    for (int frame = 0; frame < 20; ++frame) {
      std::vector<Sighting> seen = {{.pose = {110.0 - 5.0 * frame, 53.0, nan}}};
      if (frame < 8 || frame > 10) seen.push_back({.pose = {10.0 + 5.0 * frame, 50.0, nan}});
      linker.add(seen);
    }
    return linker.tracks();
  };
  // The first came first in every list
  const auto tracks = tracks_of(4);
  ASSERT_EQ(tracks.size(), 2U);
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_EQ(tracks[0][k], 0) << k;
    EXPECT_EQ(tracks[1][k], k < 8 || k > 10 ? 1 : -1) << k;
  }
  EXPECT_EQ(tracks_of(1).size(), 3U);  // a gap longer than the memory
}

// Colour tells apart what place does not, and who turned by too much is another.
TEST(TrackLinker, KnowsBodiesByColourAndAngle) {
  const Eigen::Vector3f red(100.0F, 60.0F, -20.0F), green(110.0F, -40.0F, -30.0F);
  TrackLinker linker({.reach = 12.0, .lever = 20.0});
  linker.add(
      {{.pose = {0.0, 0.0, 0.1}, .colour = red}, {.pose = {10.0, 0.0, 1.5}, .colour = green}});
  linker.add(
      {{.pose = {2.0, 0.0, 1.5}, .colour = green}, {.pose = {8.0, 0.0, 0.1}, .colour = red}});
  ASSERT_EQ(linker.tracks().size(), 2U);
  EXPECT_EQ(linker.tracks()[0], (std::vector{0, 1}));
  linker.add({{.pose = {16.0, 0.0, 1.5}, .colour = red}});
  EXPECT_EQ(linker.tracks().size(), 3U);
}

TEST(TrackLinker, CountsStepsThatCouldBeExchanged) {
  TrackLinker linker({.reach = 12.0, .lever = 5.0});
  linker.add({{.pose = {0.0, 0.0, nan}}, {.pose = {8.0, 0.0, nan}}});
  linker.add({{.pose = {3.5, 3.0, nan}}, {.pose = {4.5, -3.0, nan}}});
  EXPECT_EQ(linker.doubts(), 1);
}

// Smooth motion, whatever it is, leaves the scatter.
TEST(ScatterRatio, TellsErrorsFromMotion) {
  datasets::Trajectories tracks = datasets::make_trajectories(200, 1, true);
  std::mt19937 random(5);
  std::normal_distribution<double> error(0.0, 0.03);
  for (std::size_t k = 0; k < 200; ++k) {
    const double t = 0.02 * static_cast<double>(k);
    tracks.time[k] = t;
    tracks.poses[k] = {5.0 * t * t + error(random), std::sin(t) + error(random), nan};
    tracks.sigmas[k] = {0.01, 0.01, nan};
  }
  const ScatterRatio ratio = scatter_ratio(tracks);
  ASSERT_TRUE(ratio.position);
  EXPECT_NEAR(*ratio.position, 3.0, 0.4);
  EXPECT_FALSE(ratio.angle);
}

struct DrawnRod {
  Eigen::Vector2d from, to;
  cv::Scalar colour;
};

TEST(Rods, AreFoundThroughEachOther) {
  const std::vector<DrawnRod> rods = {{{40, 60}, {120, 60}, {40, 40, 200}},
                                      {{95, 20}, {95, 100}, {200, 80, 30}},  // over the first
                                      {{150, 30}, {210, 90}, {40, 160, 60}},
                                      {{160, 120}, {230, 110}, {30, 30, 30}},
                                      {{60, 150}, {75, 150}, {160, 50, 140}}};  // foreshortened
  cv::Mat picture(180, 260, CV_8UC3, cv::Scalar(205, 200, 198));
  for (const DrawnRod& rod : rods)
    cv::line(picture,
             cv::Point(static_cast<int>(rod.from.x()), static_cast<int>(rod.from.y())),
             cv::Point(static_cast<int>(rod.to.x()), static_cast<int>(rod.to.y())),
             rod.colour,
             7);
  cv::GaussianBlur(picture, picture, {3, 3}, 0.8);
  const std::vector<Rod> found = locate_rods(picture, {.width_px = 7.0, .longest_px = 120.0});
  ASSERT_EQ(found.size(), rods.size());
  EXPECT_TRUE(std::is_sorted(
      found.begin(), found.end(), [](auto& a, auto& b) { return a.length() > b.length(); }));
  for (const DrawnRod& rod : rods) {
    const Eigen::Vector2d centre = 0.5 * (rod.from + rod.to), axis = rod.to - rod.from;
    const auto nearest = std::min_element(found.begin(), found.end(), [&](auto& a, auto& b) {
      return (a.centre() - centre).norm() < (b.centre() - centre).norm();
    });
    EXPECT_LT((nearest->centre() - centre).norm(), 1.5);
    // OpenCV draws a line with round ends, half a width longer at both
    EXPECT_NEAR(nearest->length(), axis.norm() + 7.0, 4.0);
    const double truth = std::atan2(-axis.y(), axis.x());
    const double turned = std::remainder(nearest->angle() - truth, std::numbers::pi);
    EXPECT_NEAR(turned, 0.0, (axis.norm() < 20.0 ? 6.0 : 1.0) * std::numbers::pi / 180.0);
  }
}

TEST(Rods, AreNotLampsNorAnEmptyGround) {
  cv::Mat picture(180, 260, CV_8UC3, cv::Scalar(205, 200, 198));
  cv::circle(picture, {130, 90}, 25, cv::Scalar(20, 20, 20), cv::FILLED);
  EXPECT_TRUE(locate_rods(picture, {.width_px = 7.0, .longest_px = 120.0}).empty());
}

TEST(RealSpots, LieWhereTrackpyFindsThem) {
  const std::filesystem::path folder = recordings / "trackpy-bulk-water";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const cv::Mat picture =
      cv::imread((folder / "frames/T76S3F00001.png").string(), cv::IMREAD_GRAYSCALE);
  const auto reference = datasets::read_csv(folder / "reference_frame0_located.csv");
  const auto spots = locate_spots(255 - picture, {.diameter_px = 9, .least_mass = 1.0});
  std::vector<double> apart;
  for (std::size_t row = 0; row < reference.rows(); ++row) {
    const Eigen::Vector2d place(reference.number(row, "col"), reference.number(row, "row"));
    double nearest = 1e9;
    for (const Spot& spot : spots) nearest = std::min(nearest, (spot.pixel - place).norm());
    if (nearest < 2.0) apart.push_back(nearest);
  }
  EXPECT_GE(apart.size(), 300U);
  std::nth_element(apart.begin(), apart.begin() + static_cast<long>(apart.size() / 2), apart.end());
  EXPECT_LE(apart[apart.size() / 2], 0.1);
}

TEST(RealChessboard, GivesThePublishedLens) {
  const std::filesystem::path folder = recordings / "opencv-chessboard";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  std::vector<std::filesystem::path> views;
  for (const int view : {1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14})
    views.push_back(folder / fmt::format("left{:02}.jpg", view));
  const Lens lens = calibrate_lens(views, 9, 6);
  EXPECT_NEAR(lens.focal_px, 535.916, 0.01 * 535.916);
  EXPECT_NEAR(lens.principal_point.x(), 342.283, 0.01 * 342.283);
  EXPECT_NEAR(lens.principal_point.y(), 235.571, 0.01 * 235.571);
  // Two views are too few, and pictures without a board are said to be so.
  EXPECT_THROW(calibrate_lens({views[0], views[1]}, 9, 6), datasets::InputError);
  EXPECT_THROW(calibrate_lens({views[0], views[1], views[2]}, 4, 17), datasets::InputError);
}

}  // namespace
}  // namespace graintruth::tracking
