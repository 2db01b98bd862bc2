#include "tracking/view/fiducials.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tracking/view/steady_view.h"

namespace graintruth::tracking {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr int width = 1024, height = 768;

// Rows and columns of the same dots: taken one row off, three quarters of them still fit.
std::vector<datasets::Fiducial> grid_of_dots() {
  std::vector<datasets::Fiducial> dots;
  for (const double x : {-0.14, -0.05, 0.05, 0.14})
    for (const double z : {-0.09, -0.03, 0.03, 0.09}) dots.push_back({x, z, 0.008});
  return dots;
}

// A camera 0.8 m away, turned about the picture's row, its column and the line of sight.
Camera camera_at(double pitch, double yaw, double roll) {
  Camera::Parameters parameters = Camera::Parameters::Zero();
  parameters[0] = std::log(2100.0);
  parameters.segment<3>(2) << pitch, yaw, roll;
  parameters[7] = std::log(0.8);
  return {width, height, parameters};
}

void draw_disc(cv::Mat& picture, const Camera& camera, double x, double z, double diameter) {
  constexpr int corners = 48, fraction_bits = 6;
  std::vector<cv::Point> outline;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / corners;
    const Eigen::Vector2d pixel =
        camera.project(x + 0.5 * diameter * std::cos(angle), z + 0.5 * diameter * std::sin(angle));
    outline.emplace_back(static_cast<int>(std::lround(pixel.x() * (1 << fraction_bits))),
                         static_cast<int>(std::lround(pixel.y() * (1 << fraction_bits))));
  }
  cv::fillConvexPoly(picture, outline, cv::Scalar(30), cv::LINE_AA, fraction_bits);
}

cv::Mat picture_of(const Camera& camera, const std::vector<datasets::Fiducial>& dots) {
  cv::Mat picture(height, width, CV_8U, cv::Scalar(200));
  for (const datasets::Fiducial& dot : dots) draw_disc(picture, camera, dot.x, dot.z, dot.diameter);
  return picture;
}

RC_GTEST_PROP(Fiducials, AreNamedByATiltedCamera, ()) {
  const auto angle = [](int most_degrees) {
    return *rc::gen::inRange(-100 * most_degrees, 100 * most_degrees + 1) / 100.0 * degree;
  };
  const Camera camera = camera_at(angle(10), angle(10), angle(15));
  const std::vector<datasets::Fiducial> dots = grid_of_dots();
  cv::Mat picture = picture_of(camera, dots);
  // Others of their size between the rows, where nothing is expected
  std::mt19937 generator(static_cast<unsigned>(*rc::gen::inRange(0, 1000)));
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int k = 0; k < 12; ++k)
    draw_disc(picture, camera, 0.03 * share(generator), 0.012 * share(generator), 0.008);
  // A dot may be hidden
  const auto hidden = static_cast<std::size_t>(*rc::gen::inRange(0, 32));
  if (hidden < dots.size()) {
    const Eigen::Vector2d pixel = camera.project(dots[hidden].x, dots[hidden].z);
    cv::circle(picture,
               cv::Point(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())),
               30,
               cv::Scalar(200),
               cv::FILLED);
  }
  const std::vector<FiducialSighting> found = find_fiducials(picture, dots, 1.0);
  RC_ASSERT(found.size() == dots.size() - (hidden < dots.size()));
  for (const FiducialSighting& sighting : found) {
    const datasets::Fiducial& dot = dots[static_cast<std::size_t>(sighting.fiducial)];
    const Eigen::Vector2d pixel = disc_centroid(camera, dot.x, dot.z, dot.diameter);
    RC_ASSERT((sighting.pixel - pixel).norm() < 0.3);
  }
}

TEST(SteadyView, PutsAJumpAndATurnBack) {
  const std::vector<datasets::Fiducial> dots = grid_of_dots();
  const Camera camera = camera_at(0.0, 0.0, 0.0);
  const cv::Mat grey = picture_of(camera, dots);
  const std::vector<FiducialSighting> sightings = find_fiducials(grey, dots, 1.0);
  cv::Mat first;
  cv::cvtColor(grey, first, cv::COLOR_GRAY2BGR);
  ASSERT_EQ(sightings.size(), dots.size());
  SteadyView view(sightings);
  cv::Mat still = first.clone();
  view.hold(still, 1);
  EXPECT_EQ(cv::norm(still, first, cv::NORM_INF), 0.0);  // not touched
  EXPECT_EQ(view.largest_shift_px(), 0.0);
  // Kicked: 40 px, further than a dot is wide
  cv::Mat turn = cv::getRotationMatrix2D(cv::Point2f(300.0F, 200.0F), 0.5, 1.0), moved;
  turn.at<double>(0, 2) += 40.0;
  cv::warpAffine(first, moved, turn, first.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  view.hold(moved, 2);
  EXPECT_NEAR(view.largest_shift_px(), 40.0, 6.0);
  EXPECT_EQ(view.frame_of_largest_shift(), 2);
  cv::Mat held;
  cv::cvtColor(moved, held, cv::COLOR_BGR2GRAY);
  for (const FiducialSighting& sighting : sightings) {
    FiducialSighting now = sighting;
    ASSERT_TRUE(refine_fiducial(held, now));
    EXPECT_LT((now.pixel - sighting.pixel).norm(), 0.05);
  }
  // A hand before the rig: nothing is known, nothing is moved
  cv::Mat covered(first.size(), CV_8UC3, cv::Scalar::all(120));
  view.hold(covered, 3);
  EXPECT_EQ(view.unchecked_frames(), 1);
}

}  // namespace
}  // namespace graintruth::tracking
