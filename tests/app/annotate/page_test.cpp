// graintruth annotate: the page, used as a person uses it, and what becomes of the file that it
// makes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "app/verbs/commands.h"
#include "datasets/experiment/experiment.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "tests/support/temporary_folder.h"
#include "tracking/view/camera.h"

namespace graintruth::app {
namespace {

using Json = nlohmann::json;
using tracking::Camera;

constexpr int width = 320, height = 240;
// Markup everywhere: on the page it must be text
constexpr const char* title = "Balls </script><b onclick=x>& \"two\" <img src=x>";
constexpr const char* name = "one<b>bold<img src=x>";

// A V above a column on a light ground with six dark discs; a ball comes down after eight pictures.
class DrawnFilm {
 public:
  DrawnFilm() {
    Camera::Parameters p;
    p << std::log(900.0), 0.0, 0.02, -0.015, 0.01, 0.003, 0.004, std::log(0.9), -0.2, 0.0;
    camera_ = Camera(width, height, p);
  }

  const Camera& camera() const { return camera_; }
  static std::vector<Eigen::Vector2d> discs() {  // m
    return {{-0.13, 0.08}, {0.13, 0.08}, {-0.13, -0.09}, {0.13, -0.09}, {-0.13, 0.0}, {0.13, 0.0}};
  }

  void write(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    std::mt19937 random(4);
    for (int k = 0; k < 16; ++k) {
      constexpr int finer = 8;
      cv::Mat large(height * finer, width * finer, CV_8UC3, cv::Scalar::all(190));
      for (const Eigen::Vector2d& disc : discs()) draw_disc(large, finer, disc, 0.006, 20);
      draw_disc(large, finer, {0.0, 0.05 - (k < 8 ? 0.0 : 0.004 * (k - 7))}, 0.012, 110);
      cv::Mat picture;
      cv::resize(large, picture, {width, height}, 0.0, 0.0, cv::INTER_AREA);
      std::normal_distribution<double> noise(0.0, 1.0);
      for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
          const double change = noise(random);
          for (int channel = 0; channel < 3; ++channel) {
            auto& value = picture.at<cv::Vec3b>(row, column)[channel];
            value = cv::saturate_cast<std::uint8_t>(value + change);
          }
        }
      }
      cv::imwrite((folder / fmt::format("{:02d}.png", k)).string(), picture);
    }
  }

 private:
  void draw_disc(
      cv::Mat& large, int finer, const Eigen::Vector2d& at, double radius, int grey) const {
    std::vector<cv::Point> outline;
    constexpr int corners = 90, bits = 4;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * M_PI * i / corners;
      const Eigen::Vector2d pixel =
          camera_.project(at.x() + radius * std::cos(angle), at.y() + radius * std::sin(angle));
      // Pixel centres are integers, also in the larger picture
      outline.emplace_back(
          static_cast<int>(std::lround(((pixel.x() + 0.5) * finer - 0.5) * (1 << bits))),
          static_cast<int>(std::lround(((pixel.y() + 0.5) * finer - 0.5) * (1 << bits))));
    }
    cv::fillPoly(large, std::vector{outline}, cv::Scalar::all(grey), cv::LINE_AA, bits);
  }

  Camera camera_;
};

Json pair(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

class AnnotatePage : public testing::Test {
 protected:
  void SetUp() override {
    film_.write(folder_ / "pictures");
    std::filesystem::copy(folder_ / "pictures", folder_ / "other");
    std::ofstream(experiment()) << fmt::format(R"(title = {}
[particle]
count = 1
mass_g = 9
radius_mm = 12
[material]
elastic_modulus_gpa = 2
poisson_ratio = 0.3
friction_particle_particle = 0.3
friction_particle_wall = 0.3
restitution = 0.8
[rig]
kind = "hopper_column_piston"
column_depth_mm = 60
slope_angle_deg = 60
slope_height_mm = 60
piston_speed_mm_per_s = 40
front_back_gap_mm = 25
[camera]
frame_rate_hz = 50
annotation = "annotation.toml"
[[replicate]]
name = {}
video = "pictures"
[[replicate]]
video = "other/*.png"
)",
                                               Json(title).dump(),
                                               Json(name).dump());
    annotate("");
  }

  std::filesystem::path experiment() const { return folder_ / "experiment.toml"; }
  std::filesystem::path page() const { return folder_ / "out" / "annotate.html"; }
  void annotate(const std::string& text) const { folder_.write("annotation.toml", text); }
  void make_page() const {
    testing::internal::CaptureStdout();
    EXPECT_EQ(run_annotate({.common = {.out = folder_ / "out"}, .inputs = {experiment()}}), 0);
    EXPECT_NE(testing::internal::GetCapturedStdout().find("Open in a browser:"), std::string::npos);
  }
  std::string apply(const std::filesystem::path& file) const {
    testing::internal::CaptureStdout();
    std::string complaint;
    try {
      EXPECT_EQ(run_annotate({.inputs = {experiment()}, .apply = file}), 0);
    } catch (const datasets::InputError& error) {
      complaint = error.what();
    }
    testing::internal::GetCapturedStdout();
    return complaint;
  }

  DrawnFilm film_;
  tests::TemporaryFolder folder_;
};

// What a person knows of the film and of where things are in its picture.
Json knowledge_of(const DrawnFilm& film) {
  const Camera& camera = film.camera();
  Json known = {
      {"title", title}, {"name", name}, {"size", {width, height}}, {"discs", Json::array()}};
  for (const Eigen::Vector2d& disc : DrawnFilm::discs()) {
    known["discs"].push_back({{"pixel", pair(camera.project(disc.x(), disc.y()))},
                              {"place", {1e3 * disc.x(), 1e3 * disc.y()}}});
  }
  // The column's width is not stated: the template's 135 mm are drawn, and dragged to 80 mm
  known["rig"] = {{"from", pair(camera.project(0.0675, -0.06))},
                  {"to", pair(camera.project(0.04, -0.06))},
                  {"key", "column_width_mm"},
                  {"value", 80},
                  {"tolerance", 1.0}};
  known["check"] = {{"from", pair(camera.project(-0.05, -0.03))},
                    {"to", pair(camera.project(0.05, -0.03))},
                    {"wrong", 110},
                    {"right", 100}};
  known["mask"] = {{10, 100}, {30, 100}, {30, 130}, {10, 130}};
  known["grain"] = {{"at", pair(camera.project(0.0, 0.05))},
                    {"handle", pair(camera.project(0.012, 0.05))},
                    {"to", pair(camera.project(0.03, 0.08))},
                    {"angle", 45}};
  const Eigen::Vector2d fine(0.02, -0.08);
  known["fine"] = pair(camera.project(fine.x(), fine.y()));
  known["fine_place"] = {20, -80};
  return known;
}

TEST_F(AnnotatePage, DoesWhatAPersonDoesOnIt) {
  if (!std::filesystem::exists("/usr/bin/chromium")) GTEST_SKIP() << "chromium is not installed";
  make_page();
  folder_.write("known.json", knowledge_of(film_).dump());
  const std::filesystem::path made = folder_ / "made.toml";
  const auto use = [&] {
    return std::system(
        fmt::format("timeout 300 node '{}/tests/app/annotate/page.mjs' '{}' '{}' '{}' >'{}' 2>&1",
                    GRAINTRUTH_SOURCE_DIR,
                    page().string(),
                    (folder_ / "known.json").string(),
                    made.string(),
                    (folder_ / "said").string())
            .c_str());
  };
  ASSERT_EQ(use(), 0) << datasets::read_whole(folder_ / "said");

  // 1. The file is put in place and means what was clicked
  EXPECT_EQ(apply(made), "");
  EXPECT_EQ(datasets::read_whole(folder_ / "annotation.toml"), datasets::read_whole(made));
  const datasets::Experiment read =
      datasets::load_experiment(experiment(), datasets::Purpose::tracking);
  ASSERT_EQ(read.camera.points.size(), 7U);
  ASSERT_TRUE(read.camera.checks);
  EXPECT_EQ(read.camera.checks->at(0).length, 0.1);
  ASSERT_TRUE(read.camera.masks);
  EXPECT_EQ(read.camera.masks->at(0).corners.size(), 4U);
  ASSERT_EQ(read.starts.size(), 1U);
  EXPECT_NEAR(read.starts[0].z, 0.05, 0.001);
  EXPECT_NEAR(read.rig.moving_face->right_x, 0.04, 0.0005);
  EXPECT_TRUE(read.replicates[0].noted_event_time);
  EXPECT_FALSE(read.replicates[1].noted_event_time);

  // 2. The middles of discs are those that were drawn, and the residuals those of the library
  const Json residuals = Json::parse(datasets::read_whole(made.string() + ".residuals"));
  std::vector<tracking::CameraReference> references;
  for (int i = 0; i < 6; ++i) {
    const datasets::CameraPoint& point = read.camera.points[static_cast<std::size_t>(i)];
    const Eigen::Vector2d disc = DrawnFilm::discs()[static_cast<std::size_t>(i)];
    EXPECT_NEAR(point.column, film_.camera().project(disc.x(), disc.y()).x(), 0.15);
    EXPECT_NEAR(point.row, film_.camera().project(disc.x(), disc.y()).y(), 0.15);
    references.push_back({i, point.x, point.z, 0.0, {point.column, point.row}});
  }
  const tracking::Calibration library =
      tracking::calibrate(references,
                          {.width = width,
                           .height = height,
                           .expected_sigma_px = read.camera.click_error,
                           .least_sigma_px = read.camera.click_error});
  for (std::size_t i = 0; i < references.size(); ++i) {
    const Eigen::Vector2d miss =
        library.camera.project(references[i].x, references[i].z) - references[i].pixel;
    EXPECT_NEAR(residuals[i][0].get<double>(), miss.x(), 1e-6);
    EXPECT_NEAR(residuals[i][1].get<double>(), miss.y(), 1e-6);
  }

  // 3. A new page begins from the file
  make_page();
  const std::string html = datasets::read_whole(page());
  EXPECT_NE(html.find("noted_event_s"), std::string::npos);
}

TEST_F(AnnotatePage, RefusesAFileThatIsWrongAndLeavesAllAsItWas) {
  const std::string before = datasets::read_whole(experiment());
  const auto refused = [&](const std::string& text) {
    const std::filesystem::path file = folder_.write("made.toml", text);
    std::string complaint = apply(file);
    EXPECT_EQ(datasets::read_whole(experiment()), before);
    EXPECT_EQ(datasets::read_whole(folder_ / "annotation.toml"), "");
    EXPECT_TRUE(complaint.starts_with(file.string() + ":")) << complaint;
    return complaint.substr(std::min(complaint.size(), file.string().size()));
  };
  EXPECT_EQ(
      refused("[rig]\nslope_angle_deg = 45\n"),
      fmt::format(":2: key 'rig.slope_angle_deg' is stated otherwise in {}:15; keep one of them.",
                  experiment().string()));
  EXPECT_NE(refused("[rig]\ncolumn_width_mm = 80\n[[camera.point]]\npx = [1, 2]\n").find(":3: key"),
            std::string::npos);
  EXPECT_NE(
      refused("[rig]\ncolumn_width_mm = 80\n[camera.stick]\nfrom_px = [1, 2]\nto_px = [1, 2]\n"
              "length_mm = 3\n")
          .find(":5: key 'camera.stick.to_px' is the same point"),
      std::string::npos);
}

TEST_F(AnnotatePage, IsNamedByTheExperimentFileOnceItIsInPlace) {
  std::string text = datasets::read_whole(experiment());
  const std::string line = "annotation = \"annotation.toml\"\n";
  text.erase(text.find(line), line.size());
  folder_.write("experiment.toml", text);
  std::filesystem::remove(folder_ / "annotation.toml");
  const std::filesystem::path made =
      folder_.write("made.toml",
                    "[rig]\ncolumn_width_mm = 80\n[camera.stick]\nfrom_px = [1, 2]\nto_px = [9, "
                    "2]\nlength_mm = 3\n");
  EXPECT_EQ(apply(made), "");
  EXPECT_EQ(
      datasets::load_experiment(experiment(), datasets::Purpose::tracking).camera.stick->length,
      0.003);
  EXPECT_EQ(apply(made), "");  // once more
}

TEST_F(AnnotatePage, BeginsFromFilmsAlone) {
  const tests::TemporaryFolder& folder = folder_;
  const std::filesystem::path out = folder / "mine";
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_annotate({.common = {.out = out},
                          .inputs = {folder / "pictures/*.png", folder / "other/*.png"},
                          .rig = "flat_bin_orifice"}),
            0);
  testing::internal::GetCapturedStdout();
  EXPECT_TRUE(std::filesystem::exists(out / "annotate.html"));
  EXPECT_NE(datasets::read_whole(out / "annotation.toml").find("video = \"../pictures/*.png\""),
            std::string::npos);
  // Nothing is overwritten, and no film is believed to be there
  EXPECT_THROW(
      run_annotate({.common = {.out = out}, .inputs = {folder / "pictures"}, .rig = "walls"}),
      datasets::InputError);
  EXPECT_THROW(
      run_annotate(
          {.common = {.out = folder / "no"}, .inputs = {folder / "no.mp4"}, .rig = "walls"}),
      datasets::InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "no"));
}

}  // namespace
}  // namespace graintruth::app
