// The paint of a pair of balls against pictures whose motion is known.
#include "tracking/balls/paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracking/film/synthetic_video.h"

namespace graintruth::tracking {
namespace {

constexpr BodyShape shape{0.0278, {0.0222, 0.0222}, 0.5, 2};
constexpr double scale = 1000.0;  // px/m
const Camera camera = make_camera(160, 120, 0.0, 0.0, 1.5, scale, 0.0, 0.0);

// A pattern that lies still on the body, under light that grows to one side; `phase` makes others,
// of other pitches.
cv::Mat draw(const BodyPose& pose, double phase, double slope = 0.0) {
  cv::Mat picture(camera.height(), camera.width(), CV_8UC3);
  const double cosine = std::cos(pose.angle), sine = std::sin(pose.angle);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const Eigen::Vector2d point = camera.unproject(Eigen::Vector2d(column, row));
      const double x = point.x() - pose.x, z = point.y() - pose.z;
      const double u = cosine * x + sine * z, v = -sine * x + cosine * z;
      const double light = 1.0 + slope * (static_cast<double>(column) / picture.cols - 0.5);
      const double value =
          light * (120.0 + 60.0 * std::sin((400.0 + 200.0 * phase) * u + phase) *
                               std::cos((450.0 - 100.0 * phase) * v + 2.0 * phase));
      picture.at<cv::Vec3b>(row, column) = cv::Vec3b::all(cv::saturate_cast<std::uint8_t>(value));
    }
  }
  return picture;
}

EdgeImage seen(const cv::Mat& picture) {
  return {picture, cv::Rect(0, 0, picture.cols, picture.rows), 0.8};
}

struct PaintOfAPair : testing::Test {
  const std::array<TextureGrid, 2> grids = {make_texture_grid(shape, 0),
                                            make_texture_grid(shape, 1)};
  const BodyPose start{0.001, -0.002, 0.4};

  std::array<TexturePatch, 2> patches(const cv::Mat& picture, const BodyPose& pose) const {
    const EdgeImage image = seen(picture);
    return {sample_texture(image, camera, shape, pose, grids[0]),
            sample_texture(image, camera, shape, pose, grids[1])};
  }
  Paint learned() const {
    Paint paint;
    paint.learn(patches(draw(start, 0.3), start), 0.0F);
    return paint;
  }
};

TEST_F(PaintOfAPair, TellsHowABodyMovedUnderOtherLight) {
  const BodyPose truth{start.x + 1.3 / scale, start.z - 0.9 / scale, start.angle + 0.05};
  for (const double slope : {0.0, 0.4}) {
    const PaintFit fit =
        fit_paint(seen(draw(truth, 0.3, slope)), camera, shape, start, grids, learned());
    ASSERT_TRUE(fit.found);
    EXPECT_GT(fit.likeness, 0.95);
    EXPECT_NEAR(fit.pose.x, truth.x, 0.05 / scale);
    EXPECT_NEAR(fit.pose.z, truth.z, 0.05 / scale);
    EXPECT_NEAR(fit.pose.angle, truth.angle, 0.005);
  }
}

TEST_F(PaintOfAPair, IsToldFromThatOfOthers) {
  const PaintFit other = fit_paint(seen(draw(start, 1.9)), camera, shape, start, grids, learned());
  EXPECT_LT(other.likeness, 0.7);
}

TEST_F(PaintOfAPair, IsComparedWithItsMeanOverAllFrames) {
  std::vector<std::array<TexturePatch, 2>> frames;
  for (const double px : {-0.3, 0.0, 0.3}) {
    const BodyPose moved_to = moved(start, Eigen::Vector3d(px / scale, 0.0, 0.0));
    frames.push_back(patches(draw(moved_to, 0.3), start));
  }
  const std::vector<PaintShift> shifts = compare_paint(frames, shape, grids);
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    ASSERT_TRUE(shifts[k].found);
    EXPECT_NEAR(shifts[k].change[0] * scale, 0.3 * (static_cast<double>(k) - 1.0), 0.05);
    EXPECT_NEAR(shifts[k].change[1] * scale, 0.0, 0.05);
    EXPECT_NEAR(shifts[k].stretch * scale, 0.0, 0.05);
  }
}

}  // namespace
}  // namespace graintruth::tracking
