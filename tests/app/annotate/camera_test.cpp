// The camera on the page of annotate is the library's: one thousand random cameras.
#include "tracking/view/camera.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/support/temporary_folder.h"

namespace graintruth::tracking {
namespace {

using Json = nlohmann::json;

constexpr int width = 720, height = 576;

class Chance {
 public:
  explicit Chance(unsigned seed) : random_(seed) {}
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random_); }

 private:
  std::mt19937 random_;
};

// Any laboratory's: tilts, rolls, lenses, pixels that are not square.
Camera random_camera(Chance& chance) {
  Camera::Parameters p;
  const double focal = chance.within(700.0, 4000.0), px_per_m = chance.within(300.0, 8000.0);
  p << std::log(focal), std::log(chance.within(0.9, 1.1)), chance.within(-0.2, 0.2),
      chance.within(-0.2, 0.2), chance.within(-0.3, 0.3), chance.within(-50.0, 50.0) / px_per_m,
      chance.within(-50.0, 50.0) / px_per_m, std::log(focal / px_per_m), chance.within(-0.3, 0.3),
      chance.within(-0.1, 0.1);
  return {width, height, p};
}

Json pair(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

std::vector<Json> answers_to(const std::vector<Json>& questions) {
  const tests::TemporaryFolder folder;
  {
    std::ofstream out(folder / "questions");
    for (const Json& question : questions) out << question.dump() << "\n";
  }
  const std::string command = fmt::format("node '{}/tests/app/annotate/camera.mjs' <'{}' >'{}'",
                                          GRAINTRUTH_SOURCE_DIR,
                                          (folder / "questions").string(),
                                          (folder / "answers").string());
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::vector<Json> answers;
  std::ifstream in(folder / "answers");
  for (std::string line; std::getline(in, line);) answers.push_back(Json::parse(line));
  EXPECT_EQ(answers.size(), questions.size());
  return answers;
}

void expect_near(const Json& found, const Eigen::Vector2d& wanted, double tolerance) {
  EXPECT_NEAR(found[0].get<double>(), wanted.x(), tolerance);
  EXPECT_NEAR(found[1].get<double>(), wanted.y(), tolerance);
}

constexpr double same_px = 1.0e-6;

TEST(CameraOfThePage, ProjectsAsTheLibraryDoes) {
  std::vector<Json> questions;
  std::vector<Camera> cameras;
  std::vector<Eigen::Vector2d> places;
  Chance chance(1);
  for (int k = 0; k < 1000; ++k) {
    const Camera camera = random_camera(chance);
    const Eigen::Vector2d pixel(chance.within(0.0, width), chance.within(0.0, height));
    const Eigen::Vector2d place = camera.unproject(pixel);
    questions.push_back(
        {{"kind", "project"},
         {"width", width},
         {"height", height},
         {"parameters",
          std::vector<double>(camera.parameters().begin(), camera.parameters().end())},
         {"x", place.x()},
         {"z", place.y()},
         {"pixel", pair(pixel)},
         {"diameter", 10.0 / camera.scale(place.x(), place.y())}});
    cameras.push_back(camera);
    places.push_back(place);
  }
  const std::vector<Json> answers = answers_to(questions);
  for (std::size_t k = 0; k < answers.size(); ++k) {
    const Camera& camera = cameras[k];
    const double x = places[k].x(), z = places[k].y();
    expect_near(answers[k]["pixel"], camera.project(x, z), same_px);
    expect_near(answers[k]["back"], places[k], same_px / camera.scale(x, z));
    expect_near(answers[k]["disc"],
                disc_centroid(camera, x, z, questions[k]["diameter"].get<double>()),
                same_px);
  }
}

// Clicked with noise, from four points on; some lie where they should not.
TEST(CameraOfThePage, FitsPointsWithTheSameResiduals) {
  std::vector<Json> questions;
  std::vector<Calibration> wanted;
  Chance chance(2);
  for (int k = 0; k < 1000; ++k) {
    const Camera camera = random_camera(chance);
    const auto count = static_cast<int>(chance.within(4.0, 9.0));
    const double error = chance.within(0.05, 1.0);
    std::vector<CameraReference> references;
    Json given = Json::array();
    for (int i = 0; i < count; ++i) {
      // One in each corner first
      const double column =
          i < 4 ? chance.within(0.0, 200.0) + (i % 2) * 500.0 : chance.within(0.0, width);
      const double row =
          i < 4 ? chance.within(0.0, 150.0) + (i / 2) * 400.0 : chance.within(0.0, height);
      Eigen::Vector2d place = camera.unproject({column, row});
      const Eigen::Vector2d pixel(column + chance.normal(error), row + chance.normal(error));
      if (i == 5 && k % 25 == 0) place.x() += 25.0 / camera.scale(place.x(), place.y());
      references.push_back({i, place.x(), place.y(), 0.0, pixel});
      given.push_back(
          {{"x", place.x()}, {"z", place.y()}, {"diameter", 0.0}, {"pixel", pair(pixel)}});
    }
    const double aspect = std::exp(camera.parameters()[1]) * (1.0 + chance.normal(0.01));
    questions.push_back({{"kind", "points"},
                         {"references", given},
                         {"options",
                          {{"width", width},
                           {"height", height},
                           {"pixelAspect", aspect},
                           {"expectedSigma", error},
                           {"leastSigma", error}}}});
    wanted.push_back(calibrate(references,
                               {.width = width,
                                .height = height,
                                .pixel_aspect = aspect,
                                .expected_sigma_px = error,
                                .least_sigma_px = error}));
  }
  const std::vector<Json> answers = answers_to(questions);
  for (std::size_t k = 0; k < answers.size(); ++k) {
    const Calibration& library = wanted[k];
    ASSERT_EQ(answers[k]["used"], Json(library.used)) << k;
    for (std::size_t i = 0; i < library.used.size(); ++i) {
      const auto number = static_cast<std::size_t>(library.used[i]);
      const Json& reference = questions[k]["references"][number];
      const Json& seen = answers[k]["residuals"][number];
      const Eigen::Vector2d pixel(reference["pixel"][0].get<double>(),
                                  reference["pixel"][1].get<double>());
      const Eigen::Vector2d miss =
          library.camera.project(reference["x"].get<double>(), reference["z"].get<double>()) -
          pixel;
      expect_near(seen["px"], miss, same_px);
      // Of a millionth of a pixel, in the direction in which it is longest in the plane
      const Eigen::Matrix2d plane_from_pixel =
          library.camera.jacobian(reference["x"].get<double>(), reference["z"].get<double>())
              .inverse();
      const double pixel_mm = 1.0e3 * plane_from_pixel.norm();
      EXPECT_NEAR(seen["mm"].get<double>(), 1.0e3 * library.residuals[i], same_px * pixel_mm);
    }
    for (int i = 0; i < 10; ++i) {
      const double sigma = std::sqrt(library.covariance(i, i));
      EXPECT_NEAR(
          answers[k]["sigmas"][static_cast<std::size_t>(i)].get<double>(), sigma, 1e-4 * sigma)
          << k;
    }
  }
}

TEST(CameraOfThePage, MeasuresLengthsByAStickAlike) {
  std::vector<Json> questions;
  std::vector<Calibration> wanted;
  Chance chance(3);
  const auto click = [&] {
    return Eigen::Vector2d(chance.within(0.0, width), chance.within(0.0, height));
  };
  for (int k = 0; k < 200; ++k) {
    const KnownLength stick{click(), click(), chance.within(0.01, 1.0), 0.003, click()};
    const double aspect = chance.within(0.9, 1.1);
    questions.push_back(
        {{"kind", "stick"},
         {"stick",
          {{"from", pair(stick.from)},
           {"to", pair(stick.to)},
           {"origin", pair(stick.origin)},
           {"length", stick.length},
           {"relativeSigma", stick.relative_sigma}}},
         {"options", {{"width", width}, {"height", height}, {"pixelAspect", aspect}}},
         {"from", pair(click())},
         {"to", pair(click())},
         {"click", 0.7}});
    wanted.push_back(
        level_camera(stick, {.width = width, .height = height, .pixel_aspect = aspect}));
  }
  const std::vector<Json> answers = answers_to(questions);
  for (std::size_t k = 0; k < answers.size(); ++k) {
    const auto point = [&](const char* name) {
      const Json& at = questions[k][name];
      return Eigen::Vector2d(at[0].get<double>(), at[1].get<double>());
    };
    const MeasuredLength seen = measure_length(wanted[k], point("from"), point("to"), 0.7);
    EXPECT_NEAR(answers[k]["length"]["value"].get<double>(), seen.length, 1e-9 * seen.length);
    EXPECT_NEAR(answers[k]["length"]["sigma"].get<double>(), seen.sigma, 1e-4 * seen.sigma);
  }
}

}  // namespace
}  // namespace graintruth::tracking
