// Drawn films of discs, rods and plates without any rig: found in every picture, followed from one
// to the next.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/tracking/drawn_film.h"
#include "tests/tracking/drawn_shapes.h"

namespace graintruth::tracking {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double pixels_per_metre = 2000.0;
constexpr int width = 480, height = 360, frames = 24;

// One body's straight way; places in pixels, rows downwards.
struct Way {
  Eigen::Vector2d from, step;         // px, px a frame
  double angle = 0.0, turning = 0.0;  // rad, rad a frame; counter-clockwise as one sees it
  cv::Scalar colour;                  // blue, green, red
  Eigen::Vector2d at(int frame) const { return from + frame * step; }
  double angle_at(int frame) const { return angle + frame * turning; }
};

const cv::Scalar red(40, 50, 200), green(60, 170, 60), blue(190, 90, 40), yellow(40, 190, 210);

// A stick of 200 mm across the picture gives scale; its left end is the origin.
datasets::TrackingSpec spec_of(const datasets::SeenBody& body) {
  datasets::TrackingSpec spec;
  spec.body = body;
  spec.camera.frame_rate = frame_rate;
  spec.camera.stick = datasets::Stick{{40.0, 180.0}, {440.0, 180.0}, 0.2, 0.0, {40.0, 180.0}};
  spec.camera.click_error = 0.02;
  return spec;
}

Eigen::Vector2d pixel_of(const datasets::Pose& pose) {
  return {40.0 + pixels_per_metre * pose.x, 180.0 - pixels_per_metre * pose.z};
}

struct Errors {
  double position_px = 0.0, angle_deg = 0.0;        // rms; per axis
  double normalised = 0.0, normalised_angle = 0.0;  // rms over the stated sigmas
  int seen = 0, strangers = 0;
};

// Each track is the body that it is nearest to when it is first seen.
Errors errors_of(const TrackedFilm& film, const std::vector<Way>& ways) {
  Errors errors;
  const datasets::Trajectories& tracks = film.trajectories;
  for (std::size_t p = 0; p < static_cast<std::size_t>(tracks.particles); ++p) {
    const Way* own = nullptr;
    for (std::size_t k = 0; k < tracks.frames(); ++k) {
      const datasets::Pose& pose = tracks.poses[tracks.index(k, p)];
      if (!std::isfinite(pose.x)) continue;
      const auto frame = static_cast<int>(k);
      const Eigen::Vector2d at = pixel_of(pose);
      const auto nearest =
          std::min_element(ways.begin(), ways.end(), [&](const Way& a, const Way& b) {
            return (a.at(frame) - at).norm() < (b.at(frame) - at).norm();
          });
      if (own == nullptr) own = &*nearest;
      ++errors.seen;
      errors.strangers += own != &*nearest;
      const Eigen::Vector2d off = own->at(frame) - at;
      const datasets::Pose& sigma = tracks.sigmas[tracks.index(k, p)];
      errors.position_px += off.squaredNorm() / 2.0;
      errors.normalised += (std::pow(off.x() / sigma.x, 2) + std::pow(off.y() / sigma.z, 2)) / 2.0 /
                           (pixels_per_metre * pixels_per_metre);
      const double turned = std::remainder(pose.angle - own->angle_at(frame), std::numbers::pi);
      errors.angle_deg += turned * turned;
      errors.normalised_angle += std::pow(turned / sigma.angle, 2);
    }
  }
  for (double* sum :
       {&errors.position_px, &errors.angle_deg, &errors.normalised, &errors.normalised_angle})
    *sum = std::sqrt(*sum / errors.seen);
  errors.angle_deg /= degree;
  return errors;
}

template <typename Draw>
std::vector<cv::Mat> draw_film(const std::vector<Way>& ways,
                               const cv::Scalar& ground,
                               const Draw& draw) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < frames; ++k) {
    Canvas canvas(width, height, ground);
    for (const Way& way : ways) draw(canvas, way, k);
    pictures.push_back(canvas.picture(2.0, static_cast<unsigned>(k)));
  }
  return pictures;
}

// --- Discs ------------------------------------------------------------------------------------

constexpr double disc_px = 24.0;
const datasets::SeenBody discs{"disc", {}, {{"diameter", disc_px / pixels_per_metre}}, {}};

const std::vector<Way>& ways_of_discs() {
  static const std::vector<Way> ways = {
      {{60.3, 60.2}, {2.1, 0.4}, 0.0, 0.0, red},
      {{120.4, 150.7}, {1.3, -1.1}, 0.0, 0.0, green},
      {{220.1, 80.6}, {-0.7, 1.9}, 0.0, 0.0, blue},
      {{300.8, 250.3}, {-1.2, -1.4}, 0.0, 0.0, yellow},
      {{400.5, 100.9}, {0.3, 2.4}, 0.0, 0.0, red},
      {{80.2, 280.4}, {3.1, -0.2}, 0.0, 0.0, green},
      {{400.7, 300.1}, {0.0, 0.0}, 0.0, 0.0, blue},
  };
  return ways;
}

void draw_disc(Canvas& canvas, const Way& way, int frame) {
  canvas.ellipse(way.at(frame), 0.5 * disc_px, 0.5 * disc_px, 0.0, way.colour);
}

const std::vector<cv::Mat>& film_of_discs() {
  static const std::vector<cv::Mat> film =
      draw_film(ways_of_discs(), cv::Scalar::all(120), draw_disc);
  return film;
}

TEST(Discs, AreFollowedToAFractionOfAPixel) {
  const TrackedFilm film = track(spec_of(discs), film_of_discs());
  const int all = frames * static_cast<int>(ways_of_discs().size());
  const Errors errors = errors_of(film, ways_of_discs());
  EXPECT_EQ(film.trajectories.particles, 7);
  EXPECT_EQ(errors.seen, all);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.06);
  EXPECT_GT(errors.normalised, 0.7);
  EXPECT_LT(errors.normalised, 1.4);
  EXPECT_FALSE(film.summary.shows_angle);
  EXPECT_FALSE(std::isfinite(film.trajectories.poses[0].angle));
  EXPECT_EQ(film.summary.completeness, 1.0);
  EXPECT_EQ(film.summary.suspected_swaps, 0);
  // All move from the first frame on
  EXPECT_EQ(film.summary.event_source, "first frame of the film");
  EXPECT_EQ(film.trajectories.time[0], 0.0);
}

// Numbers by rows from below, left to right.
TEST(Discs, AreNumberedByPlace) {
  const TrackedFilm film = track(spec_of(discs), film_of_discs());
  const std::vector<std::size_t> rows_from_below = {6, 5, 3, 1, 4, 2, 0};
  for (std::size_t p = 0; p < rows_from_below.size(); ++p) {
    const Eigen::Vector2d at = pixel_of(film.trajectories.poses[p]);
    EXPECT_LT((at - ways_of_discs()[rows_from_below[p]].from).norm(), 1.0) << p;
  }
}

TEST(Discs, AreFoundAgainBehindAFinger) {
  std::vector<cv::Mat> film = film_of_discs();
  for (int k = 15; k < 19; ++k) {
    const Eigen::Vector2d at = ways_of_discs()[1].at(k);
    film[static_cast<std::size_t>(k)](
        cv::Rect(static_cast<int>(at.x()) - 15, static_cast<int>(at.y()) - 15, 31, 31)) =
        cv::Scalar::all(120);
  }
  const TrackedFilm tracked = track(spec_of(discs), film);
  EXPECT_EQ(tracked.trajectories.particles, 7);
  EXPECT_EQ(tracked.summary.gaps, 1);
  EXPECT_EQ(errors_of(tracked, ways_of_discs()).strangers, 0);
}

TEST(Discs, TellOfAWrongCount) {
  datasets::SeenBody stated = discs;
  stated.count = 7;
  EXPECT_FALSE(tells(track(spec_of(stated), film_of_discs()).summary, "shows"));
  stated.count = 9;
  const TrackingSummary summary = track(spec_of(stated), film_of_discs()).summary;
  EXPECT_EQ(summary.grade, Grade::warn);
  EXPECT_TRUE(tells(summary, "Frame 0 shows 7 particles but the experiment says 9."));
}

TEST(Discs, AreLookedForInTheRegionAlone) {
  datasets::TrackingSpec spec = spec_of(discs);
  spec.camera.region = std::array{0, 200, 480, 360};
  const TrackedFilm film = track(spec, film_of_discs());
  // Not seen compares false
  for (const datasets::Pose& pose : film.trajectories.poses)
    EXPECT_FALSE(pixel_of(pose).y() < 200.0);
  spec.camera.region = std::array{500, 0, 600, 100};
  EXPECT_NE(refusal(spec, film_of_discs()).find("region_px lies outside"), std::string::npos);
}

TEST(Discs, AreRefusedWhereThereAreNoneOrTooSmall) {
  const std::vector<cv::Mat> empty(4, cv::Mat(height, width, CV_8UC3, cv::Scalar::all(120)));
  EXPECT_NE(refusal(spec_of(discs), empty).find("no disc was found"), std::string::npos);
  datasets::SeenBody tiny = discs;
  tiny.lengths["diameter"] = 1.0e-3;
  EXPECT_NE(refusal(spec_of(tiny), film_of_discs()).find("only 2.0 pixels wide"),
            std::string::npos);
}

TEST(Discs, AreDrawnOverTheFilm) {
  const DrawnFilm drawn(film_of_discs());
  TrackingOptions options;
  options.overlay_file = temporary("overlay.mp4");
  options.annotated_last = temporary("last.jpg");
  track(spec_of(discs), drawn.film(), options);
  for (const auto& product : {options.overlay_file, options.annotated_last}) {
    EXPECT_TRUE(std::filesystem::exists(product)) << product;
    std::filesystem::remove(product);
  }
}

// --- Rods -------------------------------------------------------------------------------------

constexpr double rod_length = 90.0, rod_width = 8.0;  // px
const datasets::SeenBody rods{
    "rod",
    {},
    {{"length", rod_length / pixels_per_metre}, {"diameter", rod_width / pixels_per_metre}},
    {}};

// The first two cross, and so do the last two for a while.
const std::vector<Way>& ways_of_rods() {
  static const std::vector<Way> ways = {
      {{120.3, 100.2}, {0.8, 0.3}, 20 * degree, 0.4 * degree, red},
      {{130.6, 110.4}, {0.2, 0.9}, 110 * degree, -0.3 * degree, green},
      {{300.1, 80.7}, {-0.5, 0.6}, 150 * degree, 0.8 * degree, blue},
      {{380.2, 200.9}, {0.1, -0.7}, 75 * degree, 0.0, yellow},
      {{150.8, 280.3}, {1.4, 0.0}, 5 * degree, 0.2 * degree, red},
      {{240.4, 260.1}, {-0.4, 0.2}, 85 * degree, -0.2 * degree, blue},
  };
  return ways;
}

const std::vector<cv::Mat>& film_of_rods() {
  static const std::vector<cv::Mat> film = draw_film(
      ways_of_rods(), cv::Scalar::all(220), [](Canvas& canvas, const Way& way, int frame) {
        canvas.bar(way.at(frame), rod_length, rod_width, way.angle_at(frame), way.colour);
      });
  return film;
}

TEST(Rods, AreFollowedAcrossEachOther) {
  const TrackedFilm film = track(spec_of(rods), film_of_rods());
  const Errors errors = errors_of(film, ways_of_rods());
  EXPECT_EQ(film.trajectories.particles, 6);
  EXPECT_GE(errors.seen, 0.98 * frames * 6);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.6);
  EXPECT_LT(errors.angle_deg, 0.7);
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.6);
  EXPECT_GT(errors.normalised_angle, 0.5);
  EXPECT_LT(errors.normalised_angle, 1.6);
  EXPECT_TRUE(film.summary.shows_angle);
  EXPECT_EQ(film.summary.angle_jumps, 0);
}

TEST(Rods, AreRefusedWhereTheyAreTooThin) {
  datasets::SeenBody thin = rods;
  thin.lengths["diameter"] = 1.0e-3;
  EXPECT_NE(refusal(spec_of(thin), film_of_rods()).find("only 2.0 pixels thick"),
            std::string::npos);
}

// --- Plates -----------------------------------------------------------------------------------

const datasets::SeenBody plates{"plate",
                                {},
                                {{"semi_major", 20.0 / pixels_per_metre},
                                 {"semi_minor", 13.0 / pixels_per_metre},
                                 {"thickness", 2.0e-3}},
                                {}};

const std::vector<Way>& ways_of_plates() {
  static const std::vector<Way> ways = {
      {{70.3, 70.2}, {1.8, 0.4}, 20 * degree, 1.0 * degree, red},
      {{200.6, 110.4}, {0.2, 1.9}, 110 * degree, -1.3 * degree, green},
      {{350.1, 80.7}, {-1.5, 0.6}, 150 * degree, 0.8 * degree, red},
      {{380.2, 200.9}, {0.1, -0.7}, 75 * degree, 0.0, green},
      {{100.8, 280.3}, {2.4, 0.0}, 5 * degree, 2.0 * degree, red},
      {{300.4, 300.1}, {-0.4, -0.2}, 45 * degree, -0.2 * degree, green},
  };
  return ways;
}

TEST(Plates, AreFollowedWithoutABin) {
  const std::vector<cv::Mat> pictures = draw_film(
      ways_of_plates(), cv::Scalar(225, 225, 225), [](Canvas& canvas, const Way& way, int k) {
        canvas.ellipse(way.at(k), 20.0, 13.0, way.angle_at(k), way.colour);
      });
  const TrackedFilm film = track(spec_of(plates), pictures);
  const Errors errors = errors_of(film, ways_of_plates());
  EXPECT_EQ(film.trajectories.particles, 6);
  EXPECT_EQ(errors.seen, frames * 6);
  EXPECT_EQ(errors.strangers, 0);
  EXPECT_LT(errors.position_px, 0.1);
  EXPECT_LT(errors.angle_deg, 0.5);
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.6);
}

TEST(Registry, SaysWhichBodiesNobodyFollows) {
  const datasets::SeenBody unknown{"cube", {}, {{"side", 0.01}}, 3};
  EXPECT_NE(
      refusal(spec_of(unknown), film_of_discs()).find("no tracker follows bodies of kind 'cube'"),
      std::string::npos);
}

}  // namespace
}  // namespace graintruth::tracking
