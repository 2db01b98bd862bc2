#include "tracking/film/video.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "datasets/store/input_error.h"
#include "tracking/film/synthetic_video.h"

namespace graintruth::tracking {
namespace {

class Film : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("graintruth_video_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // A bright square that moves two pixels a frame; frame `repeated` shows the one before.
  std::filesystem::path write(int frames, int repeated = -1) {
    std::vector<cv::Mat> pictures;
    for (int k = 0; k < frames; ++k) {
      cv::Mat picture(96, 128, CV_8UC3, cv::Scalar(40, 40, 40));
      const int at = k == repeated ? k - 1 : k;
      picture(cv::Rect(4 + 2 * at, 20, 30, 40)).setTo(cv::Scalar(200, 180, 160));
      pictures.push_back(picture);
    }
    const std::filesystem::path file = folder_ / "film.avi";
    write_film(file, pictures, 50.0);
    return file;
  }

  std::filesystem::path folder_;
};

std::string complaint(const std::filesystem::path& file) {
  try {
    VideoReader video(file, 50.0);
    cv::Mat frame;
    while (video.read(frame)) {
    }
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

TEST_F(Film, IsCountedByReading) {
  VideoReader video(write(20), 50.0);
  cv::Mat frame;
  int frames = 0;
  while (video.read(frame)) ++frames;
  EXPECT_EQ(frames, 20);
  EXPECT_EQ(video.frames_read(), 20);
  EXPECT_TRUE(video.warnings().empty());
}

TEST_F(Film, ThatIsMissingIsNamed) {
  const std::string sentence = complaint(folder_ / "nowhere.mp4");
  EXPECT_NE(sentence.find("nowhere.mp4"), std::string::npos);
  EXPECT_NE(sentence.find("does not exist"), std::string::npos);
}

TEST_F(Film, WithoutFramesIsRefused) {
  const std::filesystem::path empty = folder_ / "empty.mp4";
  std::ofstream(empty).close();
  EXPECT_NE(complaint(empty).find("empty"), std::string::npos);
  const std::filesystem::path text = folder_ / "text.mp4";
  std::ofstream(text) << "this is not a film";
  EXPECT_NE(complaint(text).find("text.mp4"), std::string::npos);
}

TEST_F(Film, ThatIsCutOffIsRefused) {
  const std::filesystem::path file = write(40);
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::filesystem::path cut = folder_ / "cut.avi";
  std::ofstream(cut, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size() / 2));
  EXPECT_NE(complaint(cut).find("cut.avi"), std::string::npos);
}

TEST_F(Film, TellsOfARepeatedFrame) {
  VideoReader video(write(30, 12), 50.0);
  cv::Mat frame;
  while (video.read(frame)) {
  }
  EXPECT_EQ(video.repeated_frames(), std::vector<int>{12});
}

// Fields of a frame differ from each other, so that a repeated frame repeats none before it
// directly.
TEST_F(Film, TellsOfRepeatedFramesOfTwoFields) {
  std::vector<cv::Mat> pictures;
  const auto draw = [](int moment) {
    cv::Mat picture(96, 256, CV_8UC3, cv::Scalar(40, 40, 40));
    picture(cv::Rect(4 + 3 * moment, 10, 60, 70)).setTo(cv::Scalar(200, 180, 160));
    return picture;
  };
  constexpr int repeated = 15;
  for (int k = 0; k < 30; ++k) {
    const int shown = k == repeated ? k - 1 : k;
    cv::Mat frame = draw(2 * shown);
    const cv::Mat later = draw(2 * shown + 1);
    for (int row = 1; row < frame.rows; row += 2) later.row(row).copyTo(frame.row(row));
    pictures.push_back(frame);
  }
  const std::filesystem::path file = folder_ / "woven.avi";
  write_film(file, pictures, 25.0);
  VideoReader video(file, 50.0);
  cv::Mat picture;
  while (video.read(picture)) {
  }
  EXPECT_EQ(video.scan(), Scan::even_rows_first);
  EXPECT_EQ(video.frames_read(), 60);
  EXPECT_EQ(video.repeated_frames(), std::vector<int>{2 * repeated});
}

TEST_F(Film, TellsOfAnotherFrameRate) {
  VideoReader video(write(10), 25.0);
  cv::Mat frame;
  while (video.read(frame)) {
  }
  ASSERT_EQ(video.warnings().size(), 1U);
  EXPECT_NE(video.warnings()[0].find("25"), std::string::npos);
}

// A telephone's film, whose clock now and then takes a step of 35 ms among those of 33.3 ms
TEST(RealFilm, WithAnUnevenClockIsNoticed) {
  const std::filesystem::path file = std::filesystem::path(GRAINTRUTH_SOURCE_DIR) /
                                     "../shared/real-data/lund-magnetic-discs/N20-light.mp4";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  VideoReader video(file, 30000.0 / 1001.0);
  cv::Mat frame;
  while (video.read(frame)) {
  }
  EXPECT_EQ(video.uneven_frames(), std::vector<int>({43, 127, 211, 295, 379, 463}));
}

}  // namespace
}  // namespace graintruth::tracking
