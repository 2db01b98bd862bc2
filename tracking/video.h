// Frames of a film in order, and when they were taken. The reader counts frames by reading them and
// never seeks, because OpenCV 4.6 seeks to the wrong frame in H.264 and its time stamps are 0 near
// the end of a file.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

namespace graintruth::tracking {

class VideoReader {
 public:
  // `frame_rate` is the laboratory's, in Hz, and the truth; what the container says is only
  // compared with it. Throws InputError when the file is missing, is no film, or holds no frame.
  VideoReader(const std::filesystem::path& file, double frame_rate);

  // The next frame as 8-bit BGR; false at the end. Throws InputError when the film is cut off or
  // changes its size.
  bool read(cv::Mat& frame);

  int frames_read() const { return frames_read_; }
  int declared_frames() const { return declared_frames_; }  // 0 when the container does not say
  double declared_frame_rate() const { return declared_frame_rate_; }  // Hz
  int width() const { return size_.width; }
  int height() const { return size_.height; }

  // Sentences about the clock and the frames, complete after the last read().
  std::vector<std::string> warnings() const;

  // Frames that repeat the one before them although the film moves before and after them.
  const std::vector<int>& repeated_frames() const { return repeated_frames_; }

 private:
  void note_time_stamp();
  void note_change(const cv::Mat& frame);
  void note_combing(const cv::Mat& frame);
  void finish();

  std::filesystem::path file_;
  double frame_rate_ = 0.0;
  double declared_frame_rate_ = 0.0;
  int declared_frames_ = 0;
  int frames_read_ = 0;
  bool finished_ = false;
  cv::Size size_;
  cv::VideoCapture capture_;
  cv::Mat first_frame_;
  cv::Mat previous_;                 // every fourth row and column of the frame before
  std::vector<double> changes_;      // mean absolute change from the frame before, grey levels
  std::vector<double> time_stamps_;  // s, as the container tells
  std::vector<int> repeated_frames_;
  double combed_change_ = 0.0, plain_change_ = 0.0;  // sums of row differences where the film moves
};

}  // namespace graintruth::tracking
