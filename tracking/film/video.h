// Frames of a film in order, and when they were taken; of an interlaced film its fields, each as a
// picture of full height. A film may be kept as single pictures, see
// datasets/experiment/pictures.h. The reader counts frames by reading them and
// never seeks, because OpenCV 4.6 seeks to the wrong frame in H.264 and its time stamps are 0 near
// the end of a file.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracking/film/fields.h"
#include "tracking/view/steady_view.h"

namespace graintruth::tracking {

class VideoReader {
 public:
  // `frame_rate` is the laboratory's, in Hz, and the truth (of fields, where the film is woven of
  // them); what the container says is only compared with it. Throws InputError when the file is
  // missing, is no film, or holds no frame.
  VideoReader(const std::filesystem::path& file, double frame_rate);

  // The next picture as 8-bit BGR; false at the end. Throws InputError when the film is cut off or
  // changes its size.
  bool read(cv::Mat& frame);

  // From now on pictures are put back to where the first one shows these fiducials, if any.
  void hold_steady(const std::vector<FiducialSighting>& first) {
    if (!first.empty()) steady_.emplace(first);
  }
  // How that went; nothing where it was not asked for.
  const std::optional<SteadyView>& steady() const { return steady_; }

  // Pictures: frames, or fields where frames are woven of two.
  int frames_read() const { return frames_read_; }
  int declared_frames() const { return declared_frames_; }  // 0 when the container does not say
  double declared_frame_rate() const { return declared_frame_rate_; }  // Hz

  // Known after the first read().
  Scan scan() const { return scan_; }
  // Which rows the last picture really holds: 0 or 1 for a field; -1 where it holds all.
  int parity() const { return parity_; }
  int width() const { return size_.width; }
  int height() const { return size_.height; }

  // Sentences about the clock and the frames, complete after the last read().
  std::vector<std::string> warnings() const;

  // Pictures whose time stamp comes earlier or later after the one before than usual, as the
  // container tells; complete after the last read().
  std::vector<int> uneven_frames() const;
  // What the container says of each frame, s; 0 where it says nothing.
  const std::vector<double>& time_stamps() const { return time_stamps_; }

  // Pictures that repeat earlier ones although the film moves before and after them; of a repeated
  // pair of fields the first.
  const std::vector<int>& repeated_frames() const { return repeated_frames_; }

 private:
  void open_film();
  // The next frame of the file, or the next picture.
  bool next_frame(cv::Mat& frame);
  void check_size(const cv::Mat& frame) const;
  void note_time_stamp();
  void note_change(const cv::Mat& frame);
  void finish();
  int pictures_a_frame() const { return scan_ == Scan::progressive ? 1 : 2; }

  std::filesystem::path file_;
  double frame_rate_ = 0.0;
  double declared_frame_rate_ = 0.0;
  int declared_frames_ = 0;
  int frames_read_ = 0;
  bool finished_ = false;
  cv::Size size_;
  cv::VideoCapture capture_;
  std::vector<std::filesystem::path> pictures_;  // in place of it
  std::size_t next_picture_ = 0;
  cv::Mat first_frame_;
  cv::Mat previous_;                 // every fourth row and column of the frame before
  std::vector<double> changes_;      // of each frame of the file: mean absolute change, grey levels
  std::vector<double> time_stamps_;  // s, as the container tells
  std::vector<int> repeated_frames_;
  Scan scan_ = Scan::progressive;
  int parity_ = -1;
  std::optional<SteadyView> steady_;
  cv::Mat woven_;  // the frame whose second field comes next; empty where none does
};

// Numbers of frames in a sentence: "3, 4, 9, 10, 14, 15 and 12 more".
std::string listed(const std::vector<int>& frames);

}  // namespace graintruth::tracking
