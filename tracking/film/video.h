// Frames of a film in order, and when they were taken; of an interlaced film its fields, each as a
// picture of full height. A film may be kept as single pictures, see
// datasets/experiment/pictures.h. The reader counts frames by reading them and never seeks.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracking/film/fields.h"
#include "tracking/film/film_file.h"
#include "tracking/film/single_pictures.h"
#include "tracking/view/steady_view.h"

namespace graintruth::tracking {

class VideoReader {
 public:
  // `frame_rate` is the laboratory's, in Hz (of fields, where the film is woven of them). It is the
  // truth, except where the container's time stamps are uneven: then each picture has its own.
  // Throws InputError when the file is missing, is no film, is cut off, or holds no frame.
  VideoReader(const std::filesystem::path& file, double frame_rate);

  // The next picture as 8-bit BGR, as it is to be shown; false at the end. Throws InputError when
  // the film changes its size, or too much of it cannot be decoded.
  bool read(cv::Mat& frame);

  // From now on pictures are put back to where the first one shows these fiducials, if any.
  void hold_steady(const std::vector<FiducialSighting>& first) {
    if (!first.empty()) steady_.emplace(first);
  }
  // How that went; nothing where it was not asked for.
  const std::optional<SteadyView>& steady() const { return steady_; }

  // Pictures: frames, or fields where frames are woven of two.
  int frames_read() const { return frames_read_; }
  // As the container tells; 0 when it does not say. What players do not show counts nowhere.
  int declared_frames() const { return declared_frames_; }
  double declared_frame_rate() const { return declared_frame_rate_; }  // Hz, usual in this film

  // Known after the first read().
  Scan scan() const { return scan_; }
  // Which rows the last picture really holds: 0 or 1 for a field; -1 where it holds all.
  int parity() const { return parity_; }
  int width() const { return size_.width; }
  int height() const { return size_.height; }
  // When the last picture was taken, in intervals of the frame rate after the first one: its number
  // where pictures are evenly spaced and none is lacking.
  double moment() const { return moment_; }

  // Sentences about the clock and the frames, complete after the last read().
  std::vector<std::string> warnings() const;

  // Pictures whose time stamp comes earlier or later after the one before than usual, as the
  // container tells; known after the first read().
  std::vector<int> uneven_frames() const;

  // Pictures that repeat earlier ones although the film moves before and after them; of a repeated
  // pair of fields the first.
  const std::vector<int>& repeated_frames() const { return repeated_frames_; }
  // How much changes into each frame of the file, in grey levels, mean over what is seen. Complete
  // after the last read().
  const std::vector<double>& changes() const { return changes_; }

 private:
  void open_film();
  void open_pictures();
  void begin();
  void choose_clock();
  // The next frame of the file.
  bool next_frame(cv::Mat& frame);
  void check_size(const cv::Mat& frame) const;
  void note_change(const cv::Mat& frame);
  void note_moment();
  void finish();
  void find_repeated();
  void refuse_damage() const;
  int pictures_a_frame() const { return scan_ == Scan::progressive ? 1 : 2; }

  std::filesystem::path file_;
  double frame_rate_ = 0.0;
  double declared_frame_rate_ = 0.0;
  int declared_frames_ = 0;
  int announced_frames_ = 0;  // by header or index
  int frames_read_ = 0;
  bool finished_ = false;
  bool begun_ = false;
  cv::Size stored_size_, size_;
  // A film's file, or pictures in place of it
  std::optional<FilmFile> film_;
  Container container_;
  std::vector<SinglePicture> pictures_;
  std::size_t next_picture_ = 0;
  // Of frames of the file
  cv::Mat first_frame_;
  int place_ = 0;                // of the last one read, among those in the file
  int first_place_ = -1;         // of the first that could be decoded
  cv::Mat previous_;             // every fourth row and column of the frame before
  std::vector<double> changes_;  // mean absolute change, grey levels
  std::vector<int> lost_;        // places of those that cannot be decoded
  std::vector<int> patched_;     // and of those of which parts cannot
  std::vector<int> uneven_;      // places after an unusual step
  std::vector<double> moments_;  // by place, in intervals of frames; empty: evenly spaced
  std::string clock_note_;       // how the two clocks were reconciled; empty where they agree
  // Of pictures
  std::vector<int> repeated_frames_;
  Scan scan_ = Scan::progressive;
  int parity_ = -1;
  double moment_ = 0.0;
  std::optional<SteadyView> steady_;
  cv::Mat woven_;  // the frame whose second field comes next; empty where none does
};

// Numbers of frames in a sentence: "3, 4, 9, 10, 14, 15 and 12 more".
std::string listed(const std::vector<int>& frames);

}  // namespace graintruth::tracking
