// The bundled films, set up on the page of annotate from nothing but the films and what the
// laboratory knows of them; then tracked.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/verbs/commands.h"
#include "datasets/experiment/experiment.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"
#include "tests/support/temporary_folder.h"
#include "tests/tracking/drawn_film.h"
#include "tracking/film/video.h"
#include "tracking/view/mask.h"

namespace graintruth::app {
namespace {

using Json = nlohmann::json;

constexpr int enough = 60;  // pictures, 0.8 s of motion
constexpr int particles = 10;

// What is printed meanwhile is not shown.
struct Quiet {
  Quiet() { testing::internal::CaptureStdout(); }
  ~Quiet() { testing::internal::GetCapturedStdout(); }
};

class MicroFilm : public testing::Test {
 protected:
  const std::filesystem::path micro_ =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro";
  const datasets::Experiment bundled_ = datasets::load_experiment(micro_ / "experiment.toml");
  tests::TemporaryFolder folder_;

  void SetUp() override {
    if (!std::filesystem::exists("/usr/bin/chromium")) GTEST_SKIP() << "chromium is not installed";
  }

  tracking::Calibration true_camera() const {
    const datasets::Replicate& replicate = bundled_.replicates[0];
    tracking::VideoReader video(replicate.video, 50.0);
    cv::Mat first;
    video.read(first);
    return tracking::calibrate_on(bundled_.camera, first, datasets::film_of(bundled_, replicate))
        .calibration;
  }

  // The first film without its discs, as single pictures.
  std::filesystem::path film_without_discs(const tracking::Camera& camera) const {
    datasets::Camera stated;
    stated.masks.emplace();
    for (const datasets::Fiducial& disc : bundled_.camera.fiducials) {
      const Eigen::Vector2d at = camera.project(disc.x, disc.z);
      constexpr double half = 14.0;  // px
      stated.masks->push_back({{{at.x() - half, at.y() - half},
                                {at.x() + half, at.y() - half},
                                {at.x() + half, at.y() + half},
                                {at.x() - half, at.y() + half}}});
    }
    tracking::Mask mask(stated);
    const std::filesystem::path pictures = folder_ / "rep1";
    std::filesystem::create_directories(pictures);
    tracking::VideoReader video(bundled_.replicates[0].video, 50.0);
    for (cv::Mat frame; video.frames_read() < enough && video.read(frame);) {
      mask.cover(frame);
      cv::imwrite((pictures / fmt::format("{:03d}.png", video.frames_read())).string(), frame);
    }
    return pictures / "*.png";
  }

  // What the page made of the films; what it saw on the way.
  datasets::Experiment set_up(const std::vector<std::filesystem::path>& films,
                              const std::string& scale,
                              const Json& clicks) {
    const std::filesystem::path out = folder_ / "mine";
    const Quiet quiet;
    EXPECT_EQ(
        run_annotate({.common = {.out = out}, .inputs = films, .rig = "hopper_column_piston"}), 0);
    const std::filesystem::path made = folder_ / "made.toml";
    folder_.write("made.toml.clicks", clicks.dump());
    const int status = std::system(
        fmt::format("timeout 300 node '{}/tests/app/annotate/micro.mjs' '{}' {} '{}' >'{}' 2>&1",
                    GRAINTRUTH_SOURCE_DIR,
                    (out / "annotate.html").string(),
                    scale,
                    made.string(),
                    (folder_ / "said").string())
            .c_str());
    const std::string said = datasets::read_whole(folder_ / "said");
    if (status != 0) throw std::runtime_error(said);
    seen_ = Json::parse(said, nullptr, false);
    EXPECT_LE(seen_["clicks"].get<int>(), 15);
    EXPECT_TRUE(seen_["messages"].empty()) << said;
    EXPECT_TRUE(seen_["requests"].empty()) << said;
    EXPECT_TRUE(seen_["red"].empty()) << said;
    EXPECT_EQ(run_annotate({.inputs = {out / "experiment.toml"}, .apply = made}), 0);
    return datasets::load_experiment(
        out / "experiment.toml",
        films.size() > 1 ? datasets::Purpose::calibration : datasets::Purpose::tracking);
  }

  datasets::Trajectories track(const datasets::Experiment& experiment) const {
    const datasets::Replicate& replicate = experiment.replicates[0];
    std::vector<cv::Mat> pictures;
    tracking::VideoReader video(replicate.video, 50.0);
    for (cv::Mat frame; video.frames_read() < enough && video.read(frame);)
      pictures.push_back(frame.clone());
    return tracking::track(datasets::make_tracking_spec(experiment, replicate), pictures)
        .trajectories;
  }

  struct Errors {
    double rms = 0.0;         // m, of an axis
    double normalised = 0.0;  // rms over stated sigmas
    int seen = 0;
  };
  // Against the truth; particles are those that start nearest. `may_be_shifted`: the mean of all
  // errors counts for nothing.
  Errors errors_of(const datasets::Trajectories& tracks, bool may_be_shifted) const {
    const datasets::Table truth = datasets::read_csv(micro_ / "truth" / "rep1_tracks.csv");
    std::vector<std::vector<Eigen::Vector2d>> places(enough,
                                                     std::vector<Eigen::Vector2d>(particles));
    for (std::size_t row = 0; row < truth.rows(); ++row) {
      const auto frame = static_cast<std::size_t>(truth.integer(row, "frame"));
      if (frame < places.size())
        places[frame][static_cast<std::size_t>(truth.integer(row, "particle")) - 1] = {
            truth.number(row, "x_m"), truth.number(row, "z_m")};
    }
    std::vector<Eigen::Vector2d> off;
    std::vector<Eigen::Vector2d> sigmas;
    for (std::size_t n = 0; n < static_cast<std::size_t>(tracks.particles); ++n) {
      const auto at = [&](std::size_t frame) {
        const datasets::Pose& pose = tracks.poses[tracks.index(frame, n)];
        return Eigen::Vector2d(pose.x, pose.z);
      };
      std::size_t same = 0;
      for (std::size_t k = 1; k < places[0].size(); ++k)
        if ((places[0][k] - at(0)).norm() < (places[0][same] - at(0)).norm()) same = k;
      for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
        if (!std::isfinite(at(frame).x())) continue;
        off.push_back(at(frame) - places[frame][same]);
        const auto& sigma = tracks.sigmas[tracks.index(frame, n)];
        sigmas.emplace_back(sigma.x, sigma.z);
      }
    }
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    if (may_be_shifted) {
      for (const Eigen::Vector2d& one : off) mean += one / static_cast<double>(off.size());
    }
    Errors errors{.seen = static_cast<int>(off.size())};
    for (std::size_t i = 0; i < off.size(); ++i) {
      errors.rms += (off[i] - mean).squaredNorm();
      errors.normalised += (off[i] - mean).cwiseQuotient(sigmas[i]).squaredNorm();
    }
    errors.rms = std::sqrt(errors.rms / (2.0 * errors.seen));
    errors.normalised = std::sqrt(errors.normalised / (2.0 * errors.seen));
    return errors;
  }

  Json seen_;
};

Json pair(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

TEST_F(MicroFilm, SetUpByItsDiscsIsTrackedAsTheBundledExperimentIs) {
  std::vector<std::filesystem::path> films;
  for (const datasets::Replicate& replicate : bundled_.replicates) films.push_back(replicate.video);
  const datasets::Experiment mine = set_up(films, "discs", Json::array());
  EXPECT_EQ(mine.replicates.size(), 5U);
  for (const datasets::Replicate& replicate : mine.replicates) {
    // The suggestion, told by the pictures alone
    ASSERT_TRUE(replicate.noted_event_time) << replicate.name;
    EXPECT_NEAR(*replicate.noted_event_time, 0.2, 0.04) << replicate.name;
  }
  const Errors wanted = errors_of(track(bundled_), false), found = errors_of(track(mine), false);
  EXPECT_EQ(found.seen, wanted.seen);
  EXPECT_LT(found.rms, 1.1 * wanted.rms);
  EXPECT_LT(found.normalised, 1.1 * wanted.normalised);
}

TEST_F(MicroFilm, WithoutDiscsIsSetUpByFourPoints) {
  const tracking::Camera camera = true_camera().camera;
  Json clicks = Json::array();
  for (const auto& [x, z] : {std::pair{-0.29, 0.22}, {0.29, 0.22}, {-0.29, -0.22}, {0.29, -0.22}})
    clicks.push_back(pair(camera.project(x, z)));
  const datasets::Experiment mine = set_up({film_without_discs(camera)}, "points", clicks);
  const Errors found = errors_of(track(mine), false);
  EXPECT_GT(found.seen, particles * enough * 99 / 100);
  // Four clicks are one draw of eight errors: their rms is below twice its own expectation
  EXPECT_LT(found.normalised, 2.0);
}

TEST_F(MicroFilm, WithoutDiscsIsSetUpByAStick) {
  const tracking::Camera camera = true_camera().camera;
  // The width of the throat, clicked 0.7 px off, and its middle
  const Json clicks = {pair(camera.project(-0.0675, 0.0) + Eigen::Vector2d(0.6, -0.3)),
                       pair(camera.project(0.0675, 0.0) + Eigen::Vector2d(-0.4, 0.5)),
                       pair(camera.project(0.0, 0.0))};
  const datasets::Experiment mine = set_up({film_without_discs(camera)}, "stick", clicks);
  const Errors found = errors_of(track(mine), true);
  EXPECT_GT(found.seen, particles * enough * 99 / 100);
  EXPECT_LT(found.normalised, 2.0);
}

}  // namespace
}  // namespace graintruth::app
