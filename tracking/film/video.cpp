#include "tracking/film/video.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/experiment/pictures.h"
#include "datasets/store/input_error.h"
#include "tracking/median.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// A container may count a frame or two more than can be decoded; more than this share missing means
// a cut-off file.
constexpr double tolerated_missing_share = 0.02;
constexpr int tolerated_missing_frames = 2;

// A film that is kept as pictures, or is a single one.
std::vector<std::filesystem::path> single_pictures(const std::filesystem::path& file) {
  if (std::filesystem::is_regular_file(file) && cv::haveImageReader(file.string())) return {file};
  return datasets::pictures_of(file);
}

}  // namespace

std::string listed(const std::vector<int>& frames) {
  constexpr std::size_t shown = 6;
  if (frames.size() <= shown) return fmt::format("{}", fmt::join(frames, ", "));
  return fmt::format("{} and {} more",
                     fmt::join(frames.begin(), frames.begin() + shown, ", "),
                     frames.size() - shown);
}

VideoReader::VideoReader(const std::filesystem::path& file, double frame_rate)
    : file_(file), frame_rate_(frame_rate), pictures_(single_pictures(file)) {
  if (pictures_.empty()) open_film();
  declared_frames_ = pictures_.empty()
                         ? std::max(0, static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_COUNT)))
                         : static_cast<int>(pictures_.size());
  if (!next_frame(first_frame_) || first_frame_.empty())
    throw InputError(fmt::format(
        "{}: holds no frame that can be decoded; record or copy the film again", file.string()));
  size_ = first_frame_.size();
}

void VideoReader::open_film() {
  if (!std::filesystem::exists(file_))
    throw InputError(
        fmt::format("{}: the film does not exist; give the path of a video file", file_.string()));
  if (std::filesystem::is_directory(file_))
    throw InputError(fmt::format(
        "{}: is a folder without pictures; give the path of a video file, or of pictures",
        file_.string()));
  if (std::filesystem::file_size(file_) == 0)
    throw InputError(fmt::format("{}: the file is empty; copy the film again", file_.string()));
  capture_.open(file_.string(), cv::CAP_FFMPEG);
  if (!capture_.isOpened()) {
    throw InputError(
        fmt::format("{}: cannot be opened as a film (cut off, or not a video); copy it again or "
                    "convert it to mp4",
                    file_.string()));
  }
  declared_frame_rate_ = capture_.get(cv::CAP_PROP_FPS);
}

bool VideoReader::next_frame(cv::Mat& frame) {
  if (pictures_.empty()) return capture_.read(frame) && !frame.empty();
  if (next_picture_ == pictures_.size()) return false;
  const std::filesystem::path& picture = pictures_[next_picture_++];
  frame = cv::imread(picture.string(), cv::IMREAD_COLOR);
  if (frame.empty())
    throw InputError(
        fmt::format("{}: the picture cannot be read; copy it again", picture.string()));
  return true;
}

bool VideoReader::read(cv::Mat& frame) {
  if (finished_) return false;
  if (frames_read_ == 0) {
    if (pictures_.empty()) scan_ = detect_scan(file_);
    if (scan_ != Scan::progressive) {
      declared_frames_ *= 2;
      declared_frame_rate_ *= 2.0;
    }
  }
  if (!woven_.empty()) {
    parity_ = 1 - parity_;
    frame = field_of(woven_, parity_);
    woven_.release();
  } else {
    if (!first_frame_.empty()) {
      frame = first_frame_;
      first_frame_.release();
    } else if (!next_frame(frame)) {
      finish();
      return false;
    }
    check_size(frame);
    note_time_stamp();
    note_change(frame);  // before fields are taken apart: a repeated frame repeats both
    if (scan_ != Scan::progressive) {
      woven_ = frame.clone();
      parity_ = scan_ == Scan::even_rows_first ? 0 : 1;
      frame = field_of(woven_, parity_);
    }
  }
  if (steady_) steady_->hold(frame, frames_read_);
  ++frames_read_;
  return true;
}

void VideoReader::check_size(const cv::Mat& frame) const {
  if (frame.size() != size_) {
    throw InputError(fmt::format(
        "{}: frame {} is {} x {} pixels but the film began with {} x {}; all frames must be "
        "of one size",
        file_.string(),
        frames_read_,
        frame.cols,
        frame.rows,
        size_.width,
        size_.height));
  }
}

void VideoReader::note_time_stamp() {
  time_stamps_.push_back(pictures_.empty() ? capture_.get(cv::CAP_PROP_POS_MSEC) * 1.0e-3 : 0.0);
}

void VideoReader::note_change(const cv::Mat& frame) {
  constexpr int stride = 4;  // a sixteenth of the pixels tells a repeated frame from a new one
  cv::Mat sparse(frame.rows / stride, frame.cols / stride, CV_8U);
  for (int row = 0; row < sparse.rows; ++row) {
    const cv::Vec3b* from = frame.ptr<cv::Vec3b>(row * stride);
    std::uint8_t* to = sparse.ptr<std::uint8_t>(row);
    for (int column = 0; column < sparse.cols; ++column) to[column] = from[column * stride][1];
  }
  if (previous_.empty()) {
    changes_.push_back(0.0);
  } else {
    changes_.push_back(cv::norm(sparse, previous_, cv::NORM_L1) /
                       static_cast<double>(sparse.total()));
  }
  previous_ = sparse;
}

void VideoReader::finish() {
  finished_ = true;
  const int missing = declared_frames_ - frames_read_;
  if (missing >
      std::max<double>(tolerated_missing_frames, tolerated_missing_share * declared_frames_)) {
    throw InputError(fmt::format(
        "{}: the film breaks off after frame {} although its header announces {} frames; copy "
        "or record it again",
        file_.string(),
        frames_read_ - 1,
        declared_frames_));
  }
  // A repeated frame: no change at all between two that change as usual.
  constexpr int neighbourhood = 4;
  const auto frames = static_cast<int>(changes_.size());
  for (int frame = 2; frame + 1 < frames; ++frame) {
    std::vector<double> around;
    for (int other = std::max(1, frame - neighbourhood);
         other <= std::min(frames - 1, frame + neighbourhood);
         ++other)
      if (other != frame) around.push_back(changes_[static_cast<std::size_t>(other)]);
    const double usual = median(around);
    const double lowest = *std::min_element(around.begin(), around.end());
    constexpr double repeated_share = 0.1;
    if (usual > 0.05 && lowest > 0.3 * usual &&
        changes_[static_cast<std::size_t>(frame)] < repeated_share * usual)
      repeated_frames_.push_back(frame * pictures_a_frame());
  }
}

// Steps that differ from the usual one by more than containers round: some count in milliseconds,
// so that a step may be one too short or too long. Zero stamps near the end are an OpenCV fault and
// mean nothing.
std::vector<int> VideoReader::uneven_frames() const {
  constexpr double rounding = 1.2e-3;   // s
  constexpr double least_share = 0.02;  // of a step
  constexpr double large_share = 0.3;   // of a step, whatever the rounding
  std::vector<double> steps;
  for (std::size_t frame = 1; frame < time_stamps_.size(); ++frame) {
    const bool known = time_stamps_[frame] > 0.0 && time_stamps_[frame] > time_stamps_[frame - 1];
    if (known) steps.push_back(time_stamps_[frame] - time_stamps_[frame - 1]);
  }
  if (steps.empty()) return {};
  const double usual = median(steps);
  const double tolerance = std::min(large_share * usual, std::max(rounding, least_share * usual));
  std::vector<int> uneven;
  for (std::size_t frame = 1; frame < time_stamps_.size(); ++frame) {
    const bool known = time_stamps_[frame] > 0.0 && (frame == 1 || time_stamps_[frame - 1] > 0.0);
    if (known && std::abs(time_stamps_[frame] - time_stamps_[frame - 1] - usual) > tolerance)
      uneven.push_back(static_cast<int>(frame) * pictures_a_frame());
  }
  return uneven;
}

std::vector<std::string> VideoReader::warnings() const {
  std::vector<std::string> sentences;
  const double rate_ratio = declared_frame_rate_ > 0.0 ? declared_frame_rate_ / frame_rate_ : 1.0;
  if (std::abs(rate_ratio - 1.0) > 0.005) {
    sentences.push_back(fmt::format(
        "The file says {:.4g} frames/s but the experiment {:.4g}; the experiment's rate "
        "was used.",
        declared_frame_rate_,
        frame_rate_));
  }
  const int missing = declared_frames_ - frames_read_;
  if (declared_frames_ > 0 && missing != 0) {
    sentences.push_back(fmt::format(
        "The file announces {} frames but {} were read.", declared_frames_, frames_read_));
  }
  if (!repeated_frames_.empty()) {
    sentences.push_back(fmt::format(
        "Frames {} repeat the frame before them while the film moves: the clock of this "
        "recording may slip there.",
        listed(repeated_frames_)));
  }
  const std::vector<int> uneven = uneven_frames();
  if (!uneven.empty()) {
    sentences.push_back(
        fmt::format("The file's time stamps are uneven at frames {}; frames were taken as evenly "
                    "spaced.",
                    listed(uneven)));
  }
  if (scan_ != Scan::progressive) {
    sentences.push_back(fmt::format(
        "The film is interlaced ({} rows first): each frame was taken apart into its two fields, "
        "which makes {:.4g} pictures/s.",
        scan_ == Scan::even_rows_first ? "even" : "odd",
        frame_rate_));
  }
  return sentences;
}

}  // namespace graintruth::tracking
