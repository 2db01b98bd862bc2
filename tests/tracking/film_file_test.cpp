// What containers say of films: how they are turned, what they hide, when each picture was taken,
// and what is lacking.
#include "tracking/film/film_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/tracking/drawn_film.h"
#include "tests/tracking/written_film.h"
#include "tracking/film/video.h"

namespace graintruth::tracking {
namespace {

constexpr int one = 1 << 16;  // of a display matrix
const cv::Size size(96, 64);

// A light field at the top left and a dark one at its right, and a square that moves.
cv::Mat picture_of(int moment) {
  cv::Mat picture(size, CV_8UC3, cv::Scalar::all(120));
  picture(cv::Rect(0, 0, 16, 16)).setTo(cv::Scalar::all(250));
  picture(cv::Rect(80, 0, 16, 16)).setTo(cv::Scalar::all(10));
  picture(cv::Rect(2 + moment, 30, 16, 16)).setTo(cv::Scalar::all(200));
  return picture;
}

// 20 ms apart, the first `hidden` of them before the film begins.
FilmToWrite film_of(int pictures, int hidden = 0) {
  FilmToWrite film;
  for (int k = 0; k < pictures; ++k) {
    film.pictures.push_back(picture_of(k));
    film.stamps.push_back(20 * (k - hidden));
  }
  return film;
}

struct Read {
  std::vector<cv::Mat> pictures;
  std::vector<double> times;  // s
  std::vector<std::string> warnings;
  std::string refusal;
};

Read read_all(const std::filesystem::path& file, double rate = 50.0) {
  Read read;
  try {
    VideoReader video(file, rate);
    cv::Mat frame;
    while (video.read(frame)) {
      read.pictures.push_back(frame);
      read.times.push_back(video.moment() / rate);
    }
    read.warnings = video.warnings();
  } catch (const datasets::InputError& error) {
    read.refusal = error.what();
  }
  return read;
}

double brightness(const cv::Mat& picture, int column, int row) {
  return cv::mean(picture(cv::Rect(column, row, 8, 8)))[0];
}

bool is_in(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class FilmInAContainer : public testing::Test {
 protected:
  std::filesystem::path write(const FilmToWrite& film, const std::string& name = "film.mov") {
    const FilmOnDisk written(folder_ / name, film);
    return folder_ / name;
  }
  Read read(const FilmToWrite& film, double rate = 50.0) { return read_all(write(film), rate); }
  std::filesystem::path shortened(const std::filesystem::path& file, double share) {
    std::filesystem::resize_file(
        file,
        static_cast<std::uintmax_t>(share * static_cast<double>(std::filesystem::file_size(file))));
    return file;
  }

  tests::TemporaryFolder folder_;
};

// The places of the light and the dark field tell turns and mirrors apart.
TEST_F(FilmInAContainer, IsTurnedAsItsDisplayMatrixSays) {
  struct Case {
    std::array<std::int32_t, 4> turn;  // a, b, c, d of the matrix
    cv::Point light, dark;             // 0 or 1: left or right, top or bottom
    bool is_mirror;
  };
  const std::vector<Case> cases = {{{one, 0, 0, one}, {0, 0}, {1, 0}, false},
                                   {{0, one, -one, 0}, {1, 0}, {1, 1}, false},
                                   {{-one, 0, 0, -one}, {1, 1}, {0, 1}, false},
                                   {{0, -one, one, 0}, {0, 1}, {0, 0}, false},
                                   {{-one, 0, 0, one}, {1, 0}, {0, 0}, true},
                                   {{one, 0, 0, -one}, {0, 1}, {1, 1}, true},
                                   {{0, one, one, 0}, {0, 0}, {0, 1}, true},
                                   {{0, -one, -one, 0}, {1, 1}, {1, 0}, true}};
  for (const Case& each : cases) {
    FilmToWrite film = film_of(12);
    const auto& [a, b, c, d] = each.turn;
    film.matrix = {a, b, 0, c, d, 0, 0, 0, 1 << 30};
    const Read seen = read(film);
    ASSERT_EQ(seen.pictures.size(), 12U) << seen.refusal;
    const cv::Mat& first = seen.pictures.front();
    EXPECT_EQ(first.size(), a != 0 ? size : cv::Size(size.height, size.width));
    const auto at = [&](const cv::Point& corner) {
      return brightness(first, corner.x * (first.cols - 12) + 2, corner.y * (first.rows - 12) + 2);
    };
    EXPECT_GT(at(each.light), 220.0) << a << ' ' << b;
    EXPECT_LT(at(each.dark), 40.0) << a << ' ' << b;
    EXPECT_EQ(!seen.warnings.empty() && is_in(seen.warnings[0], "mirrored"), each.is_mirror);
  }
}

TEST_F(FilmInAContainer, IsRefusedWhereItIsTurnedByLessThanAQuarter) {
  FilmToWrite film = film_of(4);
  const double angle = 0.5;  // rad
  const auto cosine = static_cast<std::int32_t>(one * std::cos(angle)),
             sine = static_cast<std::int32_t>(one * std::sin(angle));
  film.matrix = {cosine, sine, 0, -sine, cosine, 0, 0, 0, 1 << 30};
  EXPECT_TRUE(is_in(read(film).refusal, "turned by 29 degrees")) << read(film).refusal;
}

TEST_F(FilmInAContainer, CountsWhatAnEditListLeaves) {
  for (const int hidden : {0, 1, 17}) {
    const auto file = write(film_of(40, hidden));
    const Container says = FilmFile(file).container();
    EXPECT_EQ(says.shown, 40 - hidden);
    EXPECT_EQ(says.announced, 40 - hidden);
    EXPECT_NEAR(says.frame_rate, 50.0, 1e-9);
    const Read seen = read_all(file);
    ASSERT_EQ(seen.pictures.size(), 40U - static_cast<unsigned>(hidden)) << seen.refusal;
    EXPECT_GT(brightness(seen.pictures.front(), 6 + hidden, 34), 180.0);  // the first that is shown
    EXPECT_TRUE(seen.warnings.empty());
    EXPECT_EQ(seen.times.front(), 0.0);
  }
}

TEST_F(FilmInAContainer, IsFoundAmongOtherStreams) {
  FilmToWrite film = film_of(20);
  film.still_before = film.sound_before = true;
  Read seen = read(film);
  EXPECT_EQ(seen.pictures.size(), 20U) << seen.refusal;
  EXPECT_TRUE(seen.warnings.empty());
  film.films = 2;
  seen = read(film);
  ASSERT_EQ(seen.pictures.size(), 20U) << seen.refusal;
  EXPECT_GT(brightness(seen.pictures.front(), 2, 2), 220.0);  // not upside down
  ASSERT_EQ(seen.warnings.size(), 1U);
  EXPECT_TRUE(is_in(seen.warnings[0], "holds 2 films; the first, of 96 x 64 pixels"));
}

TEST_F(FilmInAContainer, IsRefusedWhereThereIsOnlySound) {
  FilmToWrite film = film_of(3);
  film.sound_before = true;
  film.films = 0;
  EXPECT_TRUE(
      is_in(read_all(write(film, "sound.wav")).refusal, "holds sound but no moving pictures"));
}

TEST_F(FilmInAContainer, ThatWasCutOffIsToldFromOneThatIsDamagedInBetween) {
  // 1. Cut off, with the index before the pictures, and behind them; and in another container
  EXPECT_TRUE(is_in(read_all(shortened(write(film_of(40)), 0.7)).refusal,
                    "although its header announces 40 frames: the file was cut off"));
  FilmToWrite late = film_of(40);
  late.index_first = false;
  EXPECT_TRUE(is_in(read_all(shortened(write(late), 0.7)).refusal, "it is cut off, and its index"));
  for (const char* name : {"film.avi", "film.mkv"}) {
    const std::string refusal = read_all(shortened(write(film_of(40), name), 0.7)).refusal;
    EXPECT_TRUE(is_in(refusal, "breaks off after frame")) << name << refusal;
    EXPECT_TRUE(is_in(refusal, "was cut off")) << name << refusal;
  }
  // 2. Damaged in between: little is told, much refused
  FilmToWrite film = film_of(40);
  film.spoiled = {20, 21};
  const Read seen = read(film);
  ASSERT_EQ(seen.pictures.size(), 38U) << seen.refusal;
  EXPECT_NEAR(seen.times[19], 0.38, 1e-9);
  EXPECT_NEAR(seen.times[20], 0.44, 1e-9);  // of what comes next no time is lost
  ASSERT_EQ(seen.warnings.size(), 1U);
  EXPECT_TRUE(is_in(seen.warnings[0], "Frames 20, 21 of the file cannot be decoded"));
  film.spoiled = {4, 20, 21, 39};
  const std::string refusal = read(film).refusal;
  EXPECT_TRUE(is_in(refusal, "at least 3 of 40 frames")) << refusal;
  EXPECT_TRUE(is_in(refusal, "frames 4, 20, 21)")) << refusal;
  EXPECT_TRUE(is_in(refusal, "damaged in between")) << refusal;
}

TEST_F(FilmInAContainer, IsTimedByStampsThatAreUneven) {
  FilmToWrite film = film_of(30);
  for (std::size_t k = 12; k < film.stamps.size(); ++k) film.stamps[k] += k < 20 ? 40 : 47;
  const auto expect_times = [&](const Read& seen, double unit) {
    ASSERT_EQ(seen.times.size(), film.stamps.size()) << seen.refusal;
    for (std::size_t k = 0; k < film.stamps.size(); ++k)
      EXPECT_NEAR(seen.times[k], unit * 1.0e-3 * static_cast<double>(film.stamps[k]), 1e-9);
    ASSERT_EQ(seen.warnings.size(), 1U);
    EXPECT_TRUE(is_in(seen.warnings[0], "uneven at frames 12, 20")) << seen.warnings[0];
  };
  expect_times(read(film), 1.0);
  // A camera that is ten times faster
  Read seen = read(film, 500.0);
  expect_times(seen, 0.1);
  EXPECT_TRUE(is_in(seen.warnings[0], "played 10 times slower"));
  // A rate that nothing explains
  seen = read(film, 37.0);
  expect_times(seen, 1.0);
  EXPECT_TRUE(is_in(seen.warnings[0], "which no slow motion")) << seen.warnings[0];
}

TEST_F(FilmInAContainer, IsTimedByTheStatedRateWhereStampsAreEven) {
  const auto file = write(film_of(20));
  for (const auto& [rate, words] : {std::pair(2500.0, "played 50 times slower"),
                                    {100.0, "played 2 times slower"},
                                    {25.0, "played 2 times faster"},
                                    {37.0, "which no slow motion"}}) {
    const Read seen = read_all(file, rate);
    ASSERT_EQ(seen.times.size(), 20U);
    EXPECT_EQ(seen.times.back(), 19.0 / rate);
    ASSERT_EQ(seen.warnings.size(), 1U);
    EXPECT_TRUE(is_in(seen.warnings[0], words)) << seen.warnings[0];
  }
}

// A disc that falls freely is seen at the moments that the stamps tell.
TEST_F(FilmInAContainer, GivesTracksTheTimesOfItsStamps) {
  FilmToWrite film;
  for (int k = 0; k < 24; ++k) {
    film.stamps.push_back(20 * k + (k > 9 ? 60 : 0));
    cv::Mat picture(160, 96, CV_8UC3, cv::Scalar::all(220));
    const double fallen = 0.00035 * static_cast<double>(film.stamps.back() * film.stamps.back());
    constexpr int shift = 4;
    cv::circle(picture,
               cv::Point(48 << shift, static_cast<int>((24.0 + fallen) * (1 << shift))),
               10 << shift,
               cv::Scalar::all(30),
               cv::FILLED,
               cv::LINE_AA,
               shift);
    film.pictures.push_back(picture);
  }
  datasets::TrackingSpec spec;
  spec.body = {.kind = "disc", .lengths = {{"diameter", 0.020}}, .count = 1};
  spec.camera.frame_rate = 50.0;
  spec.camera.stick = datasets::Stick{.from = {0, 80}, .to = {90, 80}, .length = 0.090};
  const auto [tracks, summary] =
      track(spec, datasets::Film{.name = "film", .video = write(film), .experiment = "film.toml"});
  ASSERT_EQ(tracks.frames(), film.stamps.size());
  for (std::size_t k = 1; k < tracks.frames(); ++k)
    EXPECT_NEAR(
        tracks.time[k] - tracks.time[0], 1.0e-3 * static_cast<double>(film.stamps[k]), 1e-9);
  EXPECT_TRUE(tells(summary, "uneven at frames 10"));
}

TEST_F(FilmInAContainer, OfPicturesIsReadInTheOrderOfTheirNumbers) {
  const auto picture = [&](const std::string& name, int moment) {
    cv::imwrite(folder_ / name, picture_of(moment));
  };
  for (int k = 8; k < 20; ++k) picture("img_" + std::to_string(k) + ".png", k);
  for (const char* path : {"", "img_*.png", "img_%d.png"}) {
    const Read seen = read_all(folder_ / path);
    ASSERT_EQ(seen.pictures.size(), 12U) << seen.refusal;
    for (int k = 0; k < 12; ++k)
      EXPECT_GT(brightness(seen.pictures[static_cast<std::size_t>(k)], 14 + k, 34), 180.0);
    EXPECT_TRUE(seen.warnings.empty());
  }
  EXPECT_EQ(read_all(folder_ / "img_8.png").pictures.size(), 1U);
  // Numbers that are left out
  std::filesystem::remove(folder_ / "img_11.png");
  std::filesystem::remove(folder_ / "img_12.png");
  Read seen = read_all(folder_.path());
  ASSERT_EQ(seen.warnings.size(), 1U);
  EXPECT_TRUE(is_in(seen.warnings[0], "2 pictures are lacking between img_10.png and img_13.png"));
  EXPECT_NEAR(seen.times[3], 5.0 / 50.0, 1e-12);
  // Another size, a copy of another kind, and no picture at all
  cv::imwrite(folder_ / "img_14.png", cv::Mat(20, 30, CV_8UC3));
  EXPECT_TRUE(
      is_in(read_all(folder_.path()).refusal, "img_14.png: is 30 x 20 pixels but img_8.png"));
  picture("img_14.png", 14);
  picture("img_9.bmp", 9);
  EXPECT_TRUE(is_in(read_all(folder_.path()).refusal, "shows the same as img_9.bmp"))
      << read_all(folder_.path()).refusal;
  std::filesystem::remove(folder_ / "img_9.bmp");
  folder_.write("img_15.png", "no picture");
  EXPECT_TRUE(is_in(read_all(folder_.path()).refusal, "img_15.png: the picture cannot be read"));
}

TEST_F(FilmInAContainer, MayBeThePagesOfATiffFile) {
  const std::vector<cv::Mat> pages = {picture_of(0), picture_of(1), picture_of(2)};
  ASSERT_TRUE(cv::imwritemulti(folder_ / "pages.tif", pages));
  const Read seen = read_all(folder_ / "pages.tif");
  ASSERT_EQ(seen.pictures.size(), 3U) << seen.refusal;
  EXPECT_EQ(cv::norm(seen.pictures[2], pages[2], cv::NORM_INF), 0.0);
}

TEST_F(FilmInAContainer, OfOnePictureShowsNoMotion) {
  FilmToWrite film = film_of(1);
  datasets::TrackingSpec spec;
  const datasets::Film named{.name = "film", .video = write(film), .experiment = "film.toml"};
  EXPECT_NO_THROW(require_motion(spec, named, 1));
  spec.rig.walls.push_back({"floor", 0.0, 0.0, 1.0, 0.0});
  EXPECT_NO_THROW(require_motion(spec, named, 2));
  EXPECT_THROW(require_motion(spec, named, 1), datasets::InputError);
}

// Films of a phone and of a cutting program, that were read upside down and called broken
TEST(FilmOfAPhone, IsReadAsPlayersShowIt) {
  const std::filesystem::path cases =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/cases";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << cases << " is not here";
  cv::Mat turned, upright;
  ASSERT_TRUE(VideoReader(cases / "fail-03/film1.mp4", 50.0).read(turned));
  ASSERT_TRUE(VideoReader(cases / "fail-03/upright/film1.mp4", 50.0).read(upright));
  ASSERT_EQ(turned.size(), upright.size());
  EXPECT_LT(cv::norm(turned, upright, cv::NORM_L1) / static_cast<double>(3 * turned.total()), 3.0);
  EXPECT_EQ(FilmFile(cases / "fail-04/film1.mp4").container().shown, 45);
}

}  // namespace
}  // namespace graintruth::tracking
