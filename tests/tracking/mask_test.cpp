// What is masked is not seen, and stands still.
#include "tracking/view/mask.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace graintruth::tracking {
namespace {

// A slope of grey with a dark disc, which is farther right in every picture.
cv::Mat picture(int number) {
  cv::Mat frame(100, 160, CV_8UC3);
  for (int column = 0; column < frame.cols; ++column)
    frame.col(column).setTo(cv::Scalar::all(80 + column / 2));
  cv::circle(frame, {60 + 4 * number, 50}, 8, cv::Scalar::all(0), cv::FILLED);
  return frame;
}

datasets::Camera masked(std::vector<std::array<double, 2>> corners) {
  datasets::Camera camera;
  camera.masks = {{datasets::MaskPolygon{std::move(corners)}}};
  return camera;
}

TEST(Mask, HidesWhatIsInItInEveryPicture) {
  Mask mask(masked({{45, 35}, {90, 35}, {90, 65}, {45, 65}}));
  cv::Mat first;
  for (int number = 0; number < 3; ++number) {
    cv::Mat frame = picture(number);
    mask.cover(frame);
    if (number == 0) first = frame;
    // Within some levels of the slope where the disc was
    for (int column = 50; column < 86; ++column)
      EXPECT_NEAR(frame.at<cv::Vec3b>(50, column)[0], 80 + column / 2, 12) << column;
    EXPECT_EQ(cv::norm(frame, first, cv::NORM_INF), 0.0);
  }
}

TEST(Mask, LeavesTheRestAndThePictureOfOthersAlone) {
  Mask mask(masked({{100, 10}, {120, 10}, {110, 30}}));
  const cv::Mat original = picture(0);
  cv::Mat frame = original;  // shares its pixels
  mask.cover(frame);
  EXPECT_EQ(cv::norm(original, picture(0), cv::NORM_INF), 0.0);
  const cv::Rect left(0, 0, 99, 100);
  EXPECT_EQ(cv::norm(frame(left), original(left), cv::NORM_INF), 0.0);
}

TEST(Mask, IsNothingWhereNoneIsStated) {
  Mask mask(datasets::Camera{});
  const cv::Mat original = picture(0);
  cv::Mat frame = original;
  mask.cover(frame);
  EXPECT_EQ(frame.data, original.data);
}

}  // namespace
}  // namespace graintruth::tracking
