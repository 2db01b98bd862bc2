#include "tracking/view/camera.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "datasets/store/input_error.h"
#include "tracking/film/synthetic_video.h"
#include "tracking/view/film_camera.h"

namespace graintruth::tracking {
namespace {

// A factor in [-1, 1] in steps of a thousandth.
double unit() { return *rc::gen::inRange(-1000, 1001) / 1000.0; }

RC_GTEST_PROP(Camera, UnprojectingUndoesProjecting, ()) {
  const Camera camera = make_camera(720,
                                    576,
                                    0.02 * unit(),
                                    0.02 * unit(),
                                    1.5 + 0.8 * unit(),
                                    1000.0 + 300.0 * unit(),
                                    0.3 * unit(),
                                    0.05 * unit(),
                                    1.0 + 0.1 * unit());
  const double x = 0.25 * unit(), z = 0.2 * unit();
  const Eigen::Vector2d back = camera.unproject(camera.project(x, z));
  RC_ASSERT(std::hypot(back.x() - x, back.y() - z) < 1.0e-8);
}

TEST(Camera, LooksWithXToTheRightAndZUp) {
  const Camera camera = make_camera(720, 576, 0.0, 0.0, 1.9, 1080.0, 0.0, 0.0);
  const Eigen::Vector2d origin = camera.project(0.0, 0.0);
  EXPECT_GT(camera.project(0.1, 0.0).x(), origin.x() + 50.0);
  EXPECT_LT(camera.project(0.0, 0.1).y(), origin.y() - 50.0);
}

// A pinhole sees a sphere off the axis as an ellipse whose centre lies further out than the
// sphere's.
TEST(SphereOutline, IsTheTangentCone) {
  const Camera camera = make_camera(720, 576, 0.0, 0.0, 0.6, 1080.0, 0.0, 0.0);
  std::vector<Eigen::Vector2d> outline(180);
  const double radius = 0.03;
  const Eigen::Vector3d centre(0.2, 0.0, 0.0);
  sphere_outline(camera, centre.x(), centre.y(), radius, outline);
  const Eigen::Vector3d eye = camera.position();
  for (const Eigen::Vector2d& pixel : outline) {
    const Eigen::Vector2d plane = camera.unproject(pixel);
    const Eigen::Vector3d ray = (Eigen::Vector3d(plane.x(), plane.y(), 0.0) - eye).normalized();
    EXPECT_NEAR((centre - eye).cross(ray).norm(), radius, 1.0e-7);
  }
}

const CalibrationOptions of_720{.width = 720, .height = 576};

std::vector<CameraReference> see(const Camera& camera, int count, double noise_px) {
  std::vector<CameraReference> layout;
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, noise_px);
  for (int i = 0; i < count; ++i) {
    const datasets::Fiducial dot{
        i % 2 == 0 ? -0.29 : 0.28, 0.22 - 0.44 * (i / 2) / ((count - 1) / 2), 0.014};
    layout.push_back({i,
                      dot.x,
                      dot.z,
                      dot.diameter,
                      disc_centroid(camera, dot.x, dot.z, dot.diameter) +
                          Eigen::Vector2d(noise(generator), noise(generator))});
  }
  return layout;
}

TEST(Calibration, RecoversWhereThingsAre) {
  const Camera truth = make_camera(720, 576, 0.01, -0.01, 1.9, 1080.0, -0.25, 0.02);
  const std::vector<CameraReference> layout = see(truth, 12, 0.03);
  const Calibration found = calibrate(layout, of_720);
  EXPECT_LT(found.rms, 0.1e-3);
  for (const auto& [x, z] : {std::pair{0.0, 0.0}, {0.1, 0.1}, {-0.12, 0.12}, {0.0, -0.2}}) {
    const Eigen::Vector2d seen = found.camera.unproject(truth.project(x, z));
    // Millimetre scale, a few sigma of what the calibration claims
    const double sigma = std::sqrt(found.point_covariance(x, z).trace());
    EXPECT_LT(std::hypot(seen.x() - x, seen.y() - z), 4.0 * sigma) << x << " " << z;
    EXPECT_LT(sigma, 0.1e-3);
  }
}

TEST(Calibration, AbsorbsPixelsThatAreNotSquare) {
  const Camera truth = make_camera(720, 576, 0.0, 0.0, 1.9, 1000.0, -0.1, 0.0, 1.067);
  const std::vector<CameraReference> layout = see(truth, 10, 0.02);
  const Calibration found = calibrate(layout, of_720);
  const Eigen::Vector2d seen = found.camera.unproject(truth.project(0.05, 0.08));
  EXPECT_NEAR(seen.x(), 0.05, 0.2e-3);
  EXPECT_NEAR(seen.y(), 0.08, 0.2e-3);
  EXPECT_NEAR(found.camera.pixel_aspect(), 1.067, 0.005);
}

TEST(Calibration, TellsOfPixelsThatAreNotAsStated) {
  const Camera truth = make_camera(720, 576, 0.0, 0.0, 1.9, 1000.0, -0.1, 0.0, 1.067);
  const std::vector<CameraReference> layout = see(truth, 10, 0.02);
  const auto warnings_where_stated = [&](double aspect) {
    const datasets::Camera stated{.pixel_aspect = aspect};
    const FilmCamera film{
        calibrate(layout, {.width = 720, .height = 576, .pixel_aspect = aspect}),
        {.name = "fiducials", .given = 10, .found = 10, .references = layout, .sightings = {{}}},
        {}};
    TrackingSummary summary;
    describe_camera(film, stated, summary);
    return summary.warnings;
  };
  EXPECT_TRUE(warnings_where_stated(1.067).empty());
  const std::vector<std::string> warnings = warnings_where_stated(1.0);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("pixel_aspect is 1.000"), std::string::npos) << warnings[0];
}

TEST(Calibration, LeavesOutADotThatLiesFarOff) {
  const Camera truth = make_camera(720, 576, 0.0, 0.0, 1.9, 1080.0, -0.2, 0.01);
  std::vector<CameraReference> layout = see(truth, 12, 0.02);
  layout[5].pixel += Eigen::Vector2d(4.0, -3.0);
  const Calibration found = calibrate(layout, of_720);
  EXPECT_EQ(found.used.size(), 11U);
  EXPECT_LT(found.rms, 0.1e-3);
}

TEST(Calibration, NeedsFourDots) {
  const Camera truth = make_camera(720, 576, 0.0, 0.0, 1.9, 1080.0, 0.0, 0.0);
  std::vector<CameraReference> layout = see(truth, 12, 0.02);
  layout.resize(3);
  EXPECT_THROW(calibrate(layout, of_720), datasets::InputError);
}

}  // namespace
}  // namespace graintruth::tracking
