// The free surface of a bed: the cut, the edge, what is lifted or turns, and whole drawn films.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/store/silhouette.h"
#include "tests/tracking/drawn_film.h"
#include "tests/tracking/drawn_shapes.h"
#include "tracking/drawing/drawing.h"
#include "tracking/film/side_by_side.h"
#include "tracking/outline/colour_model.h"
#include "tracking/outline/lift.h"
#include "tracking/outline/turning.h"
#include "tracking/outline/upper_edge.h"

namespace graintruth::tracking {
namespace {

// A picture of discs of one size, dark on light, and what speaks for them.
struct DrawnDiscs {
  cv::Mat picture;
  GrainEvidence evidence;

  DrawnDiscs(const std::vector<Eigen::Vector2d>& discs, double radius, int floor) {
    const cv::Scalar ground(200, 200, 200), dark(50, 60, 90);
    Canvas canvas(160, 100, ground);
    for (const Eigen::Vector2d& at : discs) canvas.ellipse(at, radius, radius, 0.0, dark);
    picture = canvas.picture(2.0, 1);
    evidence = {cv::Mat1f(picture.size()), cv::Mat1b(picture.size(), std::uint8_t{255}), 3.0F};
    for (int row = 0; row < picture.rows; ++row)
      for (int column = 0; column < picture.cols; ++column)
        evidence.ratio(row, column) =
            row < floor && picture.at<cv::Vec3b>(row, column)[1] < 130 ? 3.0F : -3.0F;
  }
};

// Two layers of touching discs on a floor at row 90.
std::vector<Eigen::Vector2d> two_layers(double radius) {
  std::vector<Eigen::Vector2d> discs;
  for (int i = 0; i < 8; ++i) discs.emplace_back(20.0 + 2.0 * radius * i, 90.0 - radius);
  for (int i = 0; i < 7; ++i)
    discs.emplace_back(20.0 + radius + 2.0 * radius * i, 90.0 - radius * (1.0 + std::sqrt(3.0)));
  return discs;
}

TEST(UpperEdge, IsFoundToAPartOfACell) {
  constexpr double radius = 8.0;
  constexpr int floor = 90;
  std::vector<Eigen::Vector2d> discs;
  for (int i = 0; i < 5; ++i) discs.emplace_back(20.3 + 25.2 * i, 82.4 - 3.3 * i);
  const DrawnDiscs drawn(discs, radius, floor);
  const UpperEdge edge =
      find_upper_edge(drawn.picture, drawn.evidence, {.grain = 2.0 * radius, .floor = floor});
  double sum = 0.0, square = 0.0;
  int count = 0;
  for (const Eigen::Vector2d& at : discs) {
    const auto middle = static_cast<int>(at.x());
    for (int column = middle - 5; column <= middle + 6; ++column) {
      const double aside = column - at.x();
      const double truth = at.y() - std::sqrt(radius * radius - aside * aside);
      const double error = static_cast<double>(edge.row[static_cast<std::size_t>(column)]) - truth;
      sum += error;
      square += error * error;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 0.2);
  EXPECT_LT(std::sqrt(square / count), 0.25);
}

TEST(UpperEdge, LeavesOutWhatIsThinnerThanAGrainAndKeepsGrainsInFlight) {
  constexpr double radius = 8.0;
  constexpr int floor = 90;
  auto discs = two_layers(radius);
  discs.emplace_back(60.0, 20.0);
  DrawnDiscs drawn(discs, radius, floor);
  // A scratch, as wide as a cell
  for (int row = 5; row < 60; ++row) drawn.evidence.ratio(row, 110) = 3.0F;
  const std::vector<int> top =
      cut_along_columns(drawn.evidence, {.grain = 2.0 * radius, .floor = floor});
  EXPECT_NEAR(top[60], 12, 2);
  EXPECT_GT(top[110], 55);
  EXPECT_EQ(top[5], floor) << "no grain lies there";
}

TEST(UpperEdge, SaysWhatHidesIt) {
  constexpr double radius = 8.0;
  constexpr int floor = 90;
  DrawnDiscs drawn(two_layers(radius), radius, floor);
  const cv::Rect board(60, 0, 40, 75);  // down into the upper layer
  drawn.evidence.known(board).setTo(0);
  drawn.evidence.ratio(board).setTo(0.0F);
  const UpperEdge edge =
      find_upper_edge(drawn.picture, drawn.evidence, {.grain = 2.0 * radius, .floor = floor});
  EXPECT_TRUE(edge.hidden[80]);
  EXPECT_FALSE(edge.hidden[40]);
}

TEST(ColourModel, TellsSpeckledThingsApart) {
  cv::RNG generator(1);
  std::vector<ColourModel::Colour> red, grey;
  for (int i = 0; i < 2000; ++i) {
    const auto light = static_cast<float>(generator.uniform(0.4, 1.2));
    red.emplace_back(40.0F * light, 50.0F * light, 140.0F * light);
    grey.emplace_back(90.0F * light, 95.0F * light, 92.0F * light);
  }
  EXPECT_LT(confusion(red, grey, 4, 2.0), 0.02);
  EXPECT_GT(confusion(red, red, 4, 2.0), 0.4);
}

TEST(Lift, FindsSpeedAndStart) {
  HeightRecord record;
  cv::RNG generator(3);
  for (int i = 0; i < 60; ++i) {
    const double time = 0.02 * i;
    record.time.push_back(time);
    record.height.push_back(0.08 + 0.03 * std::max(0.0, time - 0.211) + generator.gaussian(2e-5));
  }
  record.height[30] = 0.2;  // a hand
  const std::optional<Lift> lift = fit_lift(record, 0.08);
  ASSERT_TRUE(lift);
  EXPECT_TRUE(lift->start_is_seen);
  EXPECT_NEAR(lift->speed, 0.03, 3.0 * lift->speed_sigma);
  EXPECT_NEAR(lift->start, 0.211, 4.0 * lift->start_sigma);
  EXPECT_LT(lift->speed_sigma, 0.01 * 0.03);
}

TEST(Lift, DoesNotInventMotion) {
  HeightRecord record;
  cv::RNG generator(3);
  for (int i = 0; i < 60; ++i) {
    record.time.push_back(0.02 * i);
    record.height.push_back(0.08 + generator.gaussian(2e-5));
  }
  EXPECT_FALSE(fit_lift(record, 0.08));
}

TEST(Lift, WorksOutAStartThatWasNotFilmed) {
  HeightRecord record;
  cv::RNG generator(3);
  for (int i = 0; i < 60; ++i) {
    record.time.push_back(0.02 * i);
    record.height.push_back(0.003 + 0.03 * 0.02 * i + generator.gaussian(2e-5));
  }
  const std::optional<Lift> lift = fit_lift(record, 0.0);
  ASSERT_TRUE(lift);
  EXPECT_FALSE(lift->start_is_seen);
  EXPECT_NEAR(lift->start, -0.1, 0.03);
  EXPECT_NEAR(lift->speed, 0.03, 3.0 * lift->speed_sigma);
}

// Slides to either side, which are drawn 50 mm long and are 52.
TEST(Lift, IsReadOfASlideThatIsPulledAside) {
  const PlaneGrid grid(-0.08, 0.03, 0.0005, cv::Size(320, 120));
  for (const double aside : {1.0, -1.0}) {
    datasets::SeenOutline::Mover mover{.name = "slide",
                                       .drawing = {{-0.02 * aside, 0.0},
                                                   {0.03 * aside, 0.0},
                                                   {0.03 * aside, 0.004},
                                                   {-0.02 * aside, 0.004}},
                                       .velocity = {0.3 * aside, 0.0}};
    LiftWatcher watcher(mover, grid, Eigen::Vector3d(0.0, 0.0, 0.5));
    cv::RNG generator(5);
    for (int number = 0; number < 24; ++number) {
      const double moved = aside * 0.25 * std::max(0.0, 0.02 * (number - 10));
      cv::Mat1f grey(grid.size(), 80.0F);
      for (int column = 0; column < grey.cols; ++column) {
        const double along = aside * (grid.x(column) - moved);
        if (along < -0.02 || along > 0.032) continue;
        for (int row = 0; row < grey.rows; ++row)
          if (grid.z(row) > 0.0 && grid.z(row) < 0.004) grey(row, column) = 200.0F;
      }
      cv::GaussianBlur(grey, grey, cv::Size(), 1.0);
      cv::Mat1f noise(grey.size());
      generator.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
      cv::Mat picture;
      grey += noise;
      grey.convertTo(picture, CV_8U);
      watcher.look(picture, cv::Mat1b(grid.size(), std::uint8_t{255}), 0.02 * number);
    }
    const std::optional<Lift> lift = watcher.lift();
    ASSERT_TRUE(lift);
    EXPECT_TRUE(lift->start_is_seen);
    EXPECT_NEAR(lift->speed, 0.25, 0.005);
    EXPECT_NEAR(lift->start, 0.2, 0.005);
    EXPECT_NEAR(watcher.length(), 0.05, 1e-12);
    ASSERT_TRUE(watcher.longer_by(lift->start));
    EXPECT_NEAR(*watcher.longer_by(lift->start), 0.002, 0.0004);
    // Its shadow goes with it
    double from = 1.0, to = -1.0;
    for (const Eigen::Vector2d& corner : watcher.shadow(0.01)) {
      from = std::min(from, corner.x());
      to = std::max(to, corner.x());
    }
    EXPECT_NEAR(from, aside > 0.0 ? -0.01 : -0.04, 1e-6);
    EXPECT_NEAR(to, aside > 0.0 ? 0.04 : 0.01, 1e-6);
  }
}

// A pixel is a millimetre; (0, 0) lies at the pixel (120, 130).
constexpr double millimetre = 1e-3;
Eigen::Vector2d pixel_of(double x, double z) { return {120.0 + 1e3 * x, 130.0 - 1e3 * z}; }

datasets::TrackingSpec drawn_spec(double grain) {
  datasets::TrackingSpec spec;
  spec.body = {.kind = "balls", .balls = {{0.0, 0.5 * grain}}};
  spec.camera.frame_rate = frame_rate;
  for (const auto& [x, z] :
       {std::pair(-0.1, 0.0), {0.1, 0.0}, {0.1, 0.1}, {-0.1, 0.1}, {0.0, 0.05}}) {
    const Eigen::Vector2d at = pixel_of(x, z);
    spec.camera.points.push_back({at.x(), at.y(), x, z});
  }
  spec.camera.click_error = 0.05;
  return spec;
}

Camera drawn_camera() { return make_camera(240, 160, 0.0, 0.05, 1.0, 1000.0, 0.0, 0.0); }

// A rim about a drum, with a mark that turns.
cv::Mat drawn_rim(double angle, bool has_mark) {
  Canvas canvas(240, 160, {190, 190, 190});
  const Camera camera = drawn_camera();
  const auto disc = [&](double radius, const cv::Scalar& colour) {
    canvas.ellipse(camera.project(0.0, 0.05), 1e3 * radius, 1e3 * radius, 0.0, colour);
  };
  disc(0.06, {70, 70, 70});
  if (has_mark)
    canvas.bar(camera.project(0.055 * std::cos(angle), 0.05 + 0.055 * std::sin(angle)),
               6.0,
               4.0,
               angle,
               {230, 230, 230});
  disc(0.05, {20, 20, 20});
  return canvas.picture(2.0, static_cast<unsigned>(1000.0 + 1000.0 * angle));
}

TEST(Turning, IsReadFromAMarkOnTheRim) {
  const datasets::SeenOutline::Drum drum{.centre = {0.0, 0.05}, .radius = 0.05};
  constexpr double rate = -0.8;  // rad/s, clockwise
  TurningWatcher watcher(drum, drawn_camera(), {0, 0, 240, 160});
  for (int i = 0; i < 32; ++i) {
    cv::Mat grey;
    cv::cvtColor(drawn_rim(2.0 + rate * 0.02 * i, true), grey, cv::COLOR_BGR2GRAY);
    watcher.look(grey, 0.02 * i);
  }
  const std::optional<Turning> turning = watcher.turning();
  ASSERT_TRUE(turning);
  EXPECT_NEAR(turning->rate, rate, 0.01 * std::abs(rate));
  EXPECT_NEAR(turning->rate, rate, 4.0 * turning->sigma);
}

TEST(Turning, IsNotInvented) {
  const datasets::SeenOutline::Drum drum{.centre = {0.0, 0.05}, .radius = 0.05};
  TurningWatcher watcher(drum, drawn_camera(), {0, 0, 240, 160});
  for (int i = 0; i < 24; ++i) {
    cv::Mat grey;
    cv::cvtColor(drawn_rim(0.01 * i, false), grey, cv::COLOR_BGR2GRAY);
    watcher.look(grey, 0.02 * i);
  }
  EXPECT_FALSE(watcher.turning());
}

struct TrackedBed {
  TrackingSummary summary;
  datasets::Outline outline;
};

TrackedBed track_bed(const datasets::TrackingSpec& spec, const datasets::Film& film) {
  const auto tracker = make_tracker(spec, film);
  TrackedBed bed{.summary = track_film(*tracker, spec, film).summary, .outline = {}};
  bed.outline = tracker->outlines().front();
  return bed;
}

TrackedBed track_bed(const datasets::TrackingSpec& spec, const std::vector<cv::Mat>& pictures) {
  const DrawnFilm drawn(pictures);
  return track_bed(spec, drawn.film());
}

struct Look {
  cv::Scalar wall, floor, grain, tube;
};

// A heap under a tube that rises from frame 5 on. The heap is there from frame 9 on.
struct DrawnHeap {
  static constexpr double grain = 10.0 * millimetre;
  static constexpr double speed = 0.15;  // m/s
  std::vector<datasets::Ball> balls;
  std::vector<cv::Mat> pictures;
  datasets::TrackingSpec spec = drawn_spec(grain);

  explicit DrawnHeap(const Look& look) {
    for (int layer = 0; layer < 3; ++layer)
      for (int i = 0; i < 7 - 2 * layer; ++i)
        balls.push_back({{grain * (i - 3 + layer), 0.0, grain * (0.5 + layer)}, 0.5 * grain});
    for (int number = 0; number < 24; ++number) {
      Canvas canvas(240, 160, look.wall);
      canvas.bar({120.0, 145.0}, 240.0, 30.0, 0.0, look.floor);
      if (number >= 9)
        for (const datasets::Ball& ball : balls)
          canvas.ellipse(pixel_of(ball.centre.x(), ball.centre.z()), 5.0, 5.0, 0.0, look.grain);
      const double rise = speed * std::max(0, number - 5) / frame_rate;
      canvas.bar(pixel_of(0.0, 0.03 + rise), 30.0, 60.0, 0.0, look.tube);
      pictures.push_back(canvas.picture(2.0, static_cast<unsigned>(number)));
    }
    datasets::SeenOutline outline{.from_x = -0.06, .to_x = 0.06, .floor_z = 0.0};
    outline.grains_after = {{{-0.01, 0.001}, {0.01, 0.001}, {0.01, 0.015}, {-0.01, 0.015}}};
    outline.empty = {{{-0.09, 0.07}, {0.09, 0.07}, {0.09, 0.11}, {-0.09, 0.11}}};
    outline.mover = datasets::SeenOutline::Mover{
        .drawing = {{-0.015, 0.0}, {0.015, 0.0}, {0.015, 0.06}, {-0.015, 0.06}}};
    spec.rig.outline = outline;
  }

  void expect_found(const TrackedBed& tracked) const {
    const datasets::Outline& outline = tracked.outline;
    ASSERT_EQ(outline.time.size(), pictures.size());
    EXPECT_NEAR(tracked.summary.event_time_s, 5.0 / frame_rate, 0.5 / frame_rate);
    // Straight in front: the discs themselves
    const std::vector<double> truth = datasets::silhouette(balls, outline.column, {});
    double sum = 0.0, square = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const double height = outline.height[outline.index(pictures.size() - 1, k)];
      // Half of these columns is covered
      if (std::abs(std::abs(outline.column[k]) - 0.035) < 1e-6) continue;
      if (!std::isfinite(truth[k])) {
        EXPECT_FALSE(height > 0.25 * grain) << "at x = " << outline.column[k];
        continue;
      }
      ASSERT_TRUE(std::isfinite(height)) << "at x = " << outline.column[k];
      const double error = (height - truth[k]) / grain;
      sum += error;
      square += error * error;
      ++count;
    }
    EXPECT_LT(std::abs(sum / count), 0.1);
    EXPECT_LT(std::sqrt(square / count), 0.25);
  }
};

TEST(OutlineTracker, FindsAHeapDarkOnLight) {
  const DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  const TrackedBed tracked = track_bed(heap.spec, heap.pictures);
  heap.expect_found(tracked);
  ASSERT_FALSE(tracked.summary.findings.empty());
}

TEST(OutlineTracker, FindsAHeapLightOnDark) {
  const DrawnHeap heap({{30, 30, 30}, {80, 80, 80}, {210, 215, 220}, {120, 110, 110}});
  heap.expect_found(track_bed(heap.spec, heap.pictures));
}

TEST(OutlineTracker, FindsAHeapOfAnotherColourButTheSameBrightness) {
  const DrawnHeap heap({{140, 120, 100}, {60, 60, 60}, {90, 110, 170}, {40, 40, 40}});
  heap.expect_found(track_bed(heap.spec, heap.pictures));
}

TEST(OutlineTracker, SaysWhereTheStatedSpeedContradictsTheFilm) {
  DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  heap.spec.rig.outline->mover->velocity = {0.0, 1.2 * DrawnHeap::speed};
  heap.spec.rig.outline->mover->speed_is_stated = true;
  const TrackedBed tracked = track_bed(heap.spec, heap.pictures);
  EXPECT_EQ(tracked.summary.grade, Grade::fail);
  EXPECT_TRUE(tells(tracked.summary, "lift speed of"));
  EXPECT_TRUE(tells(tracked.summary, "but 180 is stated"));
}

TEST(OutlineTracker, TellsNothingOfWhatIsMasked) {
  DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  constexpr double from = 0.0175, to = 0.0275, high = 0.05;  // m
  datasets::MaskPolygon polygon;
  for (const auto& [x, z] : {std::pair(from, -0.02), {to, -0.02}, {to, high}, {from, high}}) {
    const auto pixel = pixel_of(x, z);
    polygon.corners.push_back({pixel.x(), pixel.y()});
  }
  heap.spec.camera.masks = {polygon};
  const datasets::Outline outline = track_bed(heap.spec, heap.pictures).outline;
  const std::vector<double> truth = datasets::silhouette(heap.balls, outline.column, {});
  int masked = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double x = outline.column[k];
    const double height = outline.height[outline.index(heap.pictures.size() - 1, k)];
    if (x > from && x < to) {
      EXPECT_TRUE(std::isnan(height)) << "at x = " << x;
      ++masked;
    } else if (std::abs(x) < from - DrawnHeap::grain) {
      EXPECT_NEAR(height, truth[k], 0.25 * DrawnHeap::grain) << "at x = " << x;
    }
  }
  EXPECT_GE(masked, 1);
}

TEST(OutlineTracker, TakesASinglePictureForAFilm) {
  DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  heap.spec.rig.outline->mover.reset();
  heap.pictures = {heap.pictures.back()};
  // The tube is no part of this picture
  const std::filesystem::path file = temporary("heap.png");
  Canvas canvas(240, 160, {200, 205, 200});
  canvas.bar({120.0, 145.0}, 240.0, 30.0, 0.0, {70, 70, 70});
  for (const datasets::Ball& ball : heap.balls)
    canvas.ellipse(pixel_of(ball.centre.x(), ball.centre.z()), 5.0, 5.0, 0.0, {40, 50, 110});
  write_still(file, canvas.picture(2.0, 1));
  const TrackedBed tracked = track_bed(
      heap.spec, datasets::Film{.name = "drawn", .video = file, .experiment = "drawn.toml"});
  std::filesystem::remove(file);
  EXPECT_EQ(tracked.outline.time.size(), 1u);
  EXPECT_EQ(tracked.outline.time.front(), 0.0);
}

// On the film the outline that was found; beside it the simulated bed, on the film's clock.
TEST(SideBySide, ShowsABedByItsOutline) {
  const DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  const DrawnFilm drawn(heap.pictures);
  const TrackedBed tracked = track_bed(heap.spec, drawn.film());
  datasets::Recording filmed, simulated;
  filmed.outlines = {tracked.outline};
  // As high as the heap, from a tenth of a second on
  datasets::Outline& made = simulated.outlines.emplace_back();
  made.column = tracked.outline.column;
  made.time = {0.0, 0.1};
  made.height.assign(made.column.size(), std::nan(""));
  const std::vector<double> surface = datasets::silhouette(heap.balls, made.column, {});
  made.height.insert(made.height.end(), surface.begin(), surface.end());
  SideBySideFiles files{.film = temporary("beside.mp4")};
  for (int i = 0; i < 3; ++i) files.stills.push_back(temporary(fmt::format("{}.jpg", i)));
  const std::vector<double> times = draw_side_by_side({.film = drawn.film(),
                                                       .recorded = heap.spec,
                                                       .event_time = tracked.summary.event_time_s,
                                                       .filmed = filmed,
                                                       .simulated = simulated},
                                                      files,
                                                      {});
  ASSERT_EQ(times.size(), 3U);
  EXPECT_NEAR(times.front(), 0.0, 0.5 / frame_rate);
  EXPECT_NEAR(times.back(), 0.36, 0.5 / frame_rate + 0.04);
  const auto right_of = [&](int still, double x, double z) {
    const cv::Mat picture = cv::imread(files.stills[static_cast<std::size_t>(still)].string());
    EXPECT_EQ(picture.cols, 480);
    const Eigen::Vector2d at = pixel_of(x, z);
    return picture.at<cv::Vec3b>(static_cast<int>(at.y()), 240 + static_cast<int>(at.x()));
  };
  const auto differ = [](const cv::Vec3b& a, const cv::Vec3b& b) { return cv::norm(a - b) > 30.0; };
  const cv::Vec3b ground = right_of(2, 0.05, 0.09);
  EXPECT_TRUE(differ(right_of(2, 0.005, 0.01), ground)) << "the bed is filled";
  EXPECT_FALSE(differ(right_of(0, 0.005, 0.01), ground)) << "and is not there before";
  EXPECT_TRUE(std::filesystem::exists(files.film));
  std::filesystem::remove(files.film);
  for (const auto& still : files.stills) std::filesystem::remove(still);
}

TEST(OutlineTracker, RefusesAFilmThatShowsNoGrainsWhereTheyMustBe) {
  DrawnHeap heap({{200, 205, 200}, {70, 70, 70}, {40, 50, 110}, {120, 110, 110}});
  heap.spec.rig.outline->grains_after.clear();
  EXPECT_THROW(track_bed(heap.spec, heap.pictures), datasets::InputError);
}

}  // namespace
}  // namespace graintruth::tracking
