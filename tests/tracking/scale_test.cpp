// One camera model from whatever gives scale: clicked points, a chessboard, a stick, a known lens.
#include "tracking/view/scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "datasets/experiment/pictures.h"
#include "datasets/store/input_error.h"
#include "tests/tracking/drawn_shapes.h"
#include "tracking/film/synthetic_video.h"
#include "tracking/view/film_camera.h"

namespace graintruth::tracking {
namespace {

constexpr int width = 720, height = 576;
const cv::Size size(width, height);
const datasets::Film film{.name = "film", .video = "film.mp4", .experiment = "film.toml"};

Camera tilted_camera() { return make_camera(width, height, 0.01, -0.01, 1.2, 1500.0, -0.2, 0.03); }

datasets::Camera clicked(const Camera& truth, double error_px, unsigned seed) {
  datasets::Camera stated;
  stated.click_error = error_px;
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0.0, error_px);
  for (const double x : {-0.2, -0.07, 0.06, 0.19}) {
    for (const double z : {-0.15, 0.01, 0.16}) {
      const Eigen::Vector2d pixel = truth.project(x, z);
      stated.points.push_back({pixel.x() + error(random), pixel.y() + error(random), x, z});
    }
  }
  return stated;
}

FilmCamera calibrate_on_grey(const datasets::Camera& stated) {
  return calibrate_on(stated, cv::Mat(size, CV_8UC3, cv::Scalar::all(90)), film);
}

// Errors of what pixels show, over what the calibration says of them; rms over many clicks.
TEST(ClickedPoints, GiveACameraThatKnowsItsError) {
  const Camera truth = tilted_camera();
  double square = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Calibration found = calibrate_on_grey(clicked(truth, 0.7, seed)).calibration;
    for (const auto& [x, z] : {std::pair{0.0, 0.0}, {0.12, 0.1}, {-0.15, -0.1}}) {
      const Eigen::Vector2d off =
          found.camera.unproject(truth.project(x, z)) - Eigen::Vector2d(x, z);
      square += off.dot(found.point_covariance(x, z).inverse() * off);
      count += 2;
    }
  }
  EXPECT_GT(std::sqrt(square / count), 0.6);
  EXPECT_LT(std::sqrt(square / count), 1.5);
}

TEST(ClickedPoints, AreToldWithTheirResiduals) {
  datasets::Camera stated = clicked(tilted_camera(), 0.5, 3);
  TrackingSummary summary;
  describe_camera(calibrate_on_grey(stated), stated, summary);
  EXPECT_EQ(summary.references, "points");
  EXPECT_EQ(summary.references_given, 12);
  EXPECT_EQ(summary.references_used, 12);
  EXPECT_GT(summary.calibration_rms_mm, 0.1);
  EXPECT_LT(summary.calibration_leave_one_out_rms_mm, 1.5);
  EXPECT_TRUE(summary.warnings.empty());
  // One of them lies elsewhere than stated
  stated.points[4].x += 0.02;
  TrackingSummary doubtful;
  describe_camera(calibrate_on_grey(stated), stated, doubtful);
  EXPECT_EQ(doubtful.references_used, 11);
  EXPECT_EQ(doubtful.grade, Grade::warn);
}

// Four points leave no scatter: what was stated of the clicks is believed.
TEST(ClickedPoints, OfFourAreNoBetterThanTheirClicks) {
  datasets::Camera stated = clicked(tilted_camera(), 0.5, 3);
  stated.points = {stated.points[0], stated.points[2], stated.points[9], stated.points[11]};
  const FilmCamera camera = calibrate_on_grey(stated);
  EXPECT_GE(camera.calibration.pixel_sigma, 0.5);
  TrackingSummary summary;
  describe_camera(camera, stated, summary);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("Only four points"), std::string::npos);
}

TEST(Stick, GivesScaleAndOriginOfALevelCamera) {
  datasets::Camera stated;
  stated.pixel_aspect = 1.0;
  stated.stick = datasets::Stick{{100.0, 400.0}, {500.0, 100.0}, 0.25, 0.0, {100.0, 400.0}};
  const FilmCamera film_camera = calibrate_on_grey(stated);
  const Camera& camera = film_camera.calibration.camera;
  EXPECT_NEAR(camera.scale(0.1, 0.1), 2000.0, 1e-6);
  const Eigen::Vector2d origin = camera.unproject({100.0, 400.0});
  EXPECT_NEAR(origin.norm(), 0.0, 1e-12);
  const Eigen::Vector2d end = camera.unproject({500.0, 100.0});
  EXPECT_NEAR(end.x(), 0.2, 1e-9);
  EXPECT_NEAR(end.y(), 0.15, 1e-9);
  // Half a pixel at each end of 500
  const double relative = std::sqrt(2.0) * 0.5 / 500.0;
  const Eigen::Matrix2d covariance = film_camera.calibration.point_covariance(0.2, 0.15);
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.2 * relative, 1e-7);
  EXPECT_NEAR(std::sqrt(covariance(1, 1)), 0.15 * relative, 1e-7);
  EXPECT_NEAR(film_camera.calibration.point_covariance(0.0, 0.0).norm(), 0.0, 1e-15);
}

// A known length beside the scale: told where both cannot be right.
TEST(CheckedLengths, AreToldWhereTheyContradictTheScale) {
  const Camera truth = tilted_camera();
  datasets::Camera stated = clicked(truth, 0.5, 3);
  const Eigen::Vector2d from = truth.project(-0.1, 0.05), to = truth.project(0.1, 0.05);
  const auto warnings = [&](double length) {
    stated.checks = {{{{from.x(), from.y()}, {to.x(), to.y()}, length, 0.0}}};
    TrackingSummary summary;
    describe_camera(calibrate_on_grey(stated), stated, summary);
    return summary.warnings;
  };
  EXPECT_TRUE(warnings(0.2).empty());
  ASSERT_EQ(warnings(0.21).size(), 1U);
  EXPECT_NE(warnings(0.21)[0].find("stated as 210 mm is "), std::string::npos);
}

// The error that is stated is that of many clicks.
TEST(MeasuredLengths, KnowTheirError) {
  const Camera truth = tilted_camera();
  std::mt19937 random(5);
  std::normal_distribution<double> error(0.0, 0.7);
  double square = 0.0;
  constexpr int times = 40;
  for (unsigned seed = 1; seed <= times; ++seed) {
    const Calibration found = calibrate_on_grey(clicked(truth, 0.7, seed)).calibration;
    const auto click = [&](double x, double z) -> Eigen::Vector2d {
      return truth.project(x, z) + Eigen::Vector2d(error(random), error(random));
    };
    const MeasuredLength seen = measure_length(found, click(-0.1, 0.02), click(0.05, -0.06), 0.7);
    const double off = (seen.length - 0.17) / seen.sigma;
    square += off * off;
  }
  EXPECT_GT(std::sqrt(square / times), 0.7);
  EXPECT_LT(std::sqrt(square / times), 1.4);
}

TEST(Stick, CountsPixelsThatAreNotSquare) {
  datasets::Camera stated;
  stated.pixel_aspect = 1.067;
  stated.stick = datasets::Stick{{100.0, 300.0}, {500.0, 300.0}, 0.4268, 0.0, {100.0, 300.0}};
  const Camera camera = calibrate_on_grey(stated).calibration.camera;
  EXPECT_NEAR(camera.unproject({100.0, 200.0}).y(), 0.1, 1e-9);
}

TEST(Stick, SaysWhatIsAssumed) {
  datasets::Camera stated;
  stated.stick = datasets::Stick{{100.0, 300.0}, {500.0, 300.0}, 0.4, 0.0, {100.0, 300.0}};
  TrackingSummary summary;
  describe_camera(calibrate_on_grey(stated), stated, summary);
  ASSERT_EQ(summary.warnings.size(), 1U);
  for (const char* words : {"level and square", "Nothing on the film measures it", "bend no lines"})
    EXPECT_NE(summary.warnings[0].find(words), std::string::npos) << words;
  EXPECT_EQ(summary.references, "stick");
  EXPECT_TRUE(std::isnan(summary.calibration_rms_mm));
}

// --- Chessboards ------------------------------------------------------------------------------

constexpr double square = 0.025;  // m

// A board of 8 x 6 squares, its lower left inner corner at (x, z).
cv::Mat draw_board(const Camera& camera, int columns, int rows, double x, double z) {
  Canvas canvas(width, height, cv::Scalar::all(225));
  for (int row = -1; row < rows; ++row) {
    for (int column = -1; column < columns; ++column) {
      if ((row + column) % 2 != 0) continue;
      std::vector<Eigen::Vector2d> corners;
      for (const auto& [right, up] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
        corners.push_back(camera.project(x + (column + right) * square, z + (row + up) * square));
      canvas.fill(corners, cv::Scalar::all(30));
    }
  }
  return canvas.picture(1.0, 1);
}

void expect_board_found(int columns, int rows, int stated_columns, int stated_rows) {
  const Camera truth = tilted_camera();
  const cv::Mat picture = draw_board(truth, columns, rows, -0.08, -0.05);
  datasets::Camera stated;
  stated.chessboard = datasets::Chessboard{stated_columns, stated_rows, square, -0.08, -0.05, {}};
  const FilmCamera found = calibrate_on(stated, picture, film);
  EXPECT_EQ(found.scale.found, columns * rows);
  EXPECT_EQ(found.calibration.used.size(), static_cast<std::size_t>(columns * rows));
  // The fine picture rounds edges to an eighth of a pixel
  for (const CameraReference& corner : found.scale.references)
    EXPECT_LT((truth.project(corner.x, corner.z) - corner.pixel).norm(), 0.25);
  EXPECT_LT(found.calibration.rms, 0.1e-3);
  const Eigen::Vector2d seen = found.calibration.camera.unproject(truth.project(0.05, 0.04));
  EXPECT_NEAR(seen.x(), 0.05, 0.1e-3);
  EXPECT_NEAR(seen.y(), 0.04, 0.1e-3);
}

TEST(ChessboardScale, HasItsOriginAtTheLowerLeft) { expect_board_found(7, 5, 7, 5); }

// Columns and rows may be stated the other way round: the picture tells which is which.
TEST(ChessboardScale, IsFoundLyingOnItsSide) { expect_board_found(5, 7, 7, 5); }

TEST(ChessboardScale, IsRefusedWhereThereIsNone) {
  datasets::Camera stated;
  stated.chessboard = datasets::Chessboard{7, 5, square, 0.0, 0.0, {}};
  try {
    calibrate_on_grey(stated);
    FAIL() << "was calibrated";
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no whole chessboard of 7 x 5 inner corners"),
              std::string::npos)
        << error.what();
  }
}

// A real board, held askew before a real lens. A lens from all its pictures leaves its corners
// where they are to a hundredth of a square, and has the published focal length, which one picture
// of a plane does not tell.
TEST(RealChessboard, IsAScaleWithItsLens) {
  const std::filesystem::path folder =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/real-data/opencv-chessboard";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  datasets::Camera stated;
  stated.chessboard = datasets::Chessboard{
      9, 6, square, 0.0, 0.0, datasets::StatedPicture{folder / "left01.jpg", ""}};
  const cv::Mat first = cv::imread((folder / "left01.jpg").string());
  const FilmCamera alone = calibrate_on(stated, first, film);
  stated.lens = datasets::LensBoard{9, 6, {}};
  for (const auto& picture : datasets::pictures_of(folder / "left*.jpg"))
    stated.lens->pictures.push_back({picture, ""});
  const FilmCamera informed = calibrate_on(stated, first, film);
  EXPECT_EQ(informed.calibration.used.size(), 54U);
  EXPECT_LT(informed.calibration.rms, 0.3e-3);
  EXPECT_LT(informed.calibration.leave_one_out_rms, 0.4e-3);
  EXPECT_LE(informed.calibration.rms, 1.1 * alone.calibration.rms);
  EXPECT_NEAR(informed.calibration.camera.focal_length_px(), 535.9, 0.01 * 535.9);
  EXPECT_NEAR(informed.calibration.camera.k1(), -0.27, 0.03);
}

}  // namespace
}  // namespace graintruth::tracking
