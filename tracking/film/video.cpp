#include "tracking/film/video.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tracking/median.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// Rates that differ by less are written differently: 30 for 30000/1001.
constexpr double rates_agree_to = 0.01;

bool agree(double rate, double other) { return std::abs(rate / other - 1.0) < rates_agree_to; }

// Into how many intervals of one rate an interval of the other falls, if that is a whole number:
// films of high-speed cameras are played so many times slower than they were taken.
std::optional<int> times_faster(double rate, double other) {
  const double ratio = rate / other;
  const double whole = std::round(ratio);
  if (whole < 2.0 || !agree(ratio, whole)) return std::nullopt;
  return static_cast<int>(whole);
}

// How it comes that the film was taken at `stated` and is played at `played`, as far as that is
// usual.
std::optional<std::string> explained(double stated, double played) {
  if (const auto slower = times_faster(stated, played))
    return fmt::format("it is played {} times slower than it was taken", *slower);
  if (const auto faster = times_faster(played, stated))
    return fmt::format("it is played {} times faster than it was taken", *faster);
  return std::nullopt;
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
  if (pictures_.empty())
    open_film();
  else
    open_pictures();
  if (!next_frame(first_frame_)) {
    throw InputError(fmt::format(
        "{}: holds no frame that can be decoded; record or copy the film again", file.string()));
  }
  stored_size_ = size_ = first_frame_.size();
  if (container_.turn.swaps_axes) std::swap(size_.width, size_.height);
}

void VideoReader::open_film() {
  film_.emplace(file_);
  container_ = film_->container();
  if (container_.is_cut_off()) {
    throw InputError(fmt::format(
        "{}: the film breaks off after frame {}{}: the file was cut off; copy or record it again",
        file_.string(),
        container_.shown - 1,
        container_.announced > container_.shown
            ? fmt::format(" although its header announces {} frames", container_.announced)
            : std::string(", where the file ends before it should")));
  }
  if (container_.has_holes()) {
    throw InputError(fmt::format(
        "{}: of {} frames that its index announces only {} are in the file: the file is "
        "damaged in between; copy or record it again",
        file_.string(),
        container_.announced,
        container_.shown));
  }
  declared_frames_ = container_.shown;
  announced_frames_ = container_.announced;
  declared_frame_rate_ = container_.frame_rate;
}

void VideoReader::open_pictures() {
  declared_frames_ = announced_frames_ = static_cast<int>(pictures_.size());
  Numbering numbering = numbering_of(pictures_);
  moments_ = std::move(numbering.moments);
  clock_note_ = std::move(numbering.warning);
}

// What must wait until somebody reads, as it looks at many frames.
void VideoReader::begin() {
  begun_ = true;
  if (!film_) return;
  scan_ = detect_scan(file_);
  if (scan_ != Scan::progressive) {
    declared_frames_ *= 2;
    announced_frames_ *= 2;
    declared_frame_rate_ *= 2.0;
    if (container_.turn.swaps_axes) {
      throw InputError(
          fmt::format("{}: the film is interlaced and to be shown turned by {} degrees, so that "
                      "its fields are columns; take the fields apart with a video program first",
                      file_.string(),
                      container_.turn.degrees()));
    }
  }
  choose_clock();
}

// Even time stamps only say at what rate the film is played; the laboratory knows at which it was
// taken. Uneven ones say when each picture was taken, in seconds, or in seconds of a film that is
// played slower or faster.
void VideoReader::choose_clock() {
  uneven_ = uneven_steps(container_);
  const std::vector<double>& times = container_.times;
  const double stated = frame_rate_ / pictures_a_frame();
  const double usual = container_.frame_rate;
  const auto also = usual > 0.0 ? explained(stated, usual) : std::nullopt;
  if (uneven_.empty()) {
    constexpr double told_from = 0.005;
    if (!(usual > 0.0) || std::abs(usual / stated - 1.0) <= told_from) return;
    clock_note_ = fmt::format(
        "The file says {:.4g} frames/s but the experiment {:.4g}{}; the experiment's rate was "
        "used.",
        declared_frame_rate_,
        frame_rate_,
        also ? ": " + *also
        : agree(usual, stated)
            ? ""
            : ", which no slow motion of whole steps explains: film a stop watch to be sure");
    return;
  }
  // 1. In which unit: a rate that is stated once may be that of most steps, of all, or of the
  // shortest
  std::vector<double> steps;
  for (std::size_t k = 1; k < times.size(); ++k) steps.push_back(times[k] - times[k - 1]);
  std::sort(steps.begin(), steps.end());
  if (!(steps.front() > 0.0)) {
    clock_note_ = fmt::format(
        "The file gives several frames one time stamp; frames were taken as evenly spaced, {:.4g} "
        "a second.",
        stated);
    return;
  }
  const double mean = static_cast<double>(steps.size()) / times.back();
  const double fastest = 1.0 / steps[steps.size() / 10];
  const bool in_seconds = agree(usual, stated) || agree(mean, stated) || agree(fastest, stated);
  const double factor = !in_seconds && also ? usual / stated : 1.0;
  for (const double time : times) moments_.push_back(factor * time * stated);
  // 2. What is said
  std::vector<int> pictures;
  for (const int place : uneven_) pictures.push_back(place * pictures_a_frame());
  clock_note_ = fmt::format(
      "The file's time stamps are uneven at frames {} (steps of {:.4g} to {:.4g} s, usually {:.4g} "
      "s): the time of each frame is its own stamp{}.",
      listed(pictures),
      steps.front(),
      steps.back(),
      1.0 / usual,
      in_seconds ? std::string()
      : also     ? fmt::format(", taken for {:.4g} frames/s instead of {:.4g}, as {}",
                           frame_rate_,
                           declared_frame_rate_,
                           *also)
             : fmt::format(", although they tell of {:.4g} frames/s and the experiment of {:.4g}, "
                           "which no slow motion of whole steps explains; correct frame_rate_hz",
                           declared_frame_rate_,
                           frame_rate_));
}

bool VideoReader::next_frame(cv::Mat& frame) {
  if (!film_) {
    if (next_picture_ == pictures_.size()) return false;
    place_ = static_cast<int>(next_picture_);
    first_place_ = 0;
    frame = read_picture(pictures_[next_picture_++]);
    return true;
  }
  StoredPicture stored;
  if (!film_->read(stored)) return false;
  if (first_place_ < 0) first_place_ = place_ = stored.place;
  for (int place = place_ + 1; place < stored.place; ++place) lost_.push_back(place);
  if (stored.is_patched) patched_.push_back(stored.place);
  place_ = stored.place;
  frame = stored.picture;
  return true;
}

bool VideoReader::read(cv::Mat& frame) {
  if (finished_) return false;
  if (!begun_) begin();
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
    refuse_damage();
    note_change(frame);  // before fields are taken apart: a repeated frame repeats both
    if (scan_ != Scan::progressive) {
      woven_ = frame.clone();
      parity_ = scan_ == Scan::even_rows_first ? 0 : 1;
      frame = field_of(woven_, parity_);
    }
  }
  note_moment();
  frame = container_.turn.of(frame);
  if (steady_) steady_->hold(frame, frames_read_);
  ++frames_read_;
  return true;
}

void VideoReader::note_moment() {
  const auto moment_of = [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    return i < moments_.size() ? moments_[i] : static_cast<double>(place);
  };
  const bool is_second = scan_ != Scan::progressive && woven_.empty();
  moment_ =
      (moment_of(place_) - moment_of(first_place_)) * pictures_a_frame() + (is_second ? 1.0 : 0.0);
}

void VideoReader::check_size(const cv::Mat& frame) const {
  if (frame.size() == stored_size_) return;
  if (!film_) {
    throw InputError(
        fmt::format("{}: is {} x {} pixels but {}, the first of them, {} x {}; all pictures of a "
                    "film must be of one size",
                    pictures_[static_cast<std::size_t>(place_)].file.string(),
                    frame.cols,
                    frame.rows,
                    pictures_.front().file.filename().string(),
                    stored_size_.width,
                    stored_size_.height));
  }
  throw InputError(fmt::format(
      "{}: frame {} is {} x {} pixels but the film began with {} x {}; all frames must be "
      "of one size",
      file_.string(),
      frames_read_,
      frame.cols,
      frame.rows,
      stored_size_.width,
      stored_size_.height));
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
  if (film_ && film_->refused_packets() > 0)
    for (int place = place_ + 1; place < container_.shown; ++place) lost_.push_back(place);
  refuse_damage();
  // Some packets hold no picture of their own, and nothing is wrong with them
  if (film_ && film_->refused_packets() == 0) lost_.clear();
  find_repeated();
}

// What the file holds but nobody can decode, as soon as it is too much; where the file ends was
// seen before anything was read.
void VideoReader::refuse_damage() const {
  if (!film_) return;
  std::vector<int> places = patched_;
  if (film_->refused_packets() > 0) places.insert(places.end(), lost_.begin(), lost_.end());
  if (places.empty()) return;
  // Of a damaged file steps of several intervals are frames that nobody found
  double holes = 0.0;
  for (const int place : uneven_) {
    const auto k = static_cast<std::size_t>(place);
    const double step = container_.times[k] - container_.times[k - 1];
    holes += std::max(0.0, std::round(step * container_.frame_rate) - 1.0);
  }
  const int lacking = static_cast<int>(std::min(holes, 1.0e6));
  const int bad = static_cast<int>(places.size()) + lacking, all = container_.shown + lacking;
  if (!are_too_many(bad, all)) return;
  std::sort(places.begin(), places.end());
  throw InputError(
      fmt::format("{}: at least {} of {} frames are lacking or cannot be decoded whole (frames "
                  "{}): the file is "
                  "damaged in between; copy or record it again",
                  file_.string(),
                  bad,
                  all,
                  listed(places)));
}

// A repeated frame: no change at all between two that change as usual.
void VideoReader::find_repeated() {
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

std::vector<int> VideoReader::uneven_frames() const {
  std::vector<int> pictures;
  for (const int place : uneven_) pictures.push_back(place * pictures_a_frame());
  return pictures;
}

std::vector<std::string> VideoReader::warnings() const {
  std::vector<std::string> sentences;
  if (container_.films > 1) {
    sentences.push_back(
        fmt::format("The file holds {} films; the first, of {} x {} pixels, was read.",
                    container_.films,
                    size_.width,
                    size_.height));
  }
  if (container_.turn.is_mirror()) {
    sentences.emplace_back(
        "The file says that its pictures are shown mirrored: they were read so, as players show "
        "them; take that note out of the file if the rig looks the wrong way round.");
  }
  if (!clock_note_.empty()) sentences.push_back(clock_note_);
  if (announced_frames_ > declared_frames_) {
    sentences.push_back(fmt::format(
        "The file announces {} frames but holds {}.", announced_frames_, declared_frames_));
  }
  if (first_place_ > 0) {
    sentences.push_back(
        fmt::format("The first {} frame(s) of the file cannot be decoded, because what they build "
                    "on is not in it: the film begins after them.",
                    first_place_));
  }
  if (!lost_.empty()) {
    sentences.push_back(
        fmt::format("Frames {} of the file cannot be decoded and are left out; the times of the "
                    "others count them.",
                    listed(lost_)));
  }
  if (!patched_.empty()) {
    sentences.push_back(
        fmt::format("Parts of frames {} cannot be decoded and were made up; what follows them may "
                    "be smeared.{}",
                    listed(patched_),
                    patched_.back() == place_
                        ? " The last frame is one of them: the film may have been cut off."
                        : ""));
  }
  if (!repeated_frames_.empty()) {
    sentences.push_back(fmt::format(
        "Frames {} repeat the frame before them while the film moves: the clock of this "
        "recording may slip there.",
        listed(repeated_frames_)));
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
