#include "datasets/imports/track_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "datasets/imports/column_names.h"
#include "datasets/imports/trackmate.h"
#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// A column of positions, or of their errors, and what a unit of it is in metres.
struct Axis {
  std::string column;
  double metres = 1.0;
  bool in_pixels = false;
};

class TrackReader {
 public:
  TrackReader(const Table& table, const TrackSource& source) : table_(table), source_(source) {}

  ReadTracks read() {
    if (table_.rows() == 0) {
      throw InputError(
          fmt::format("{}: the file has a header but no rows.", table_.file().string()));
    }
    result_.notes = table_.notes();
    find_columns();
    find_frames();
    find_particles();
    fill();
    unwrap_angles(result_.tracks);
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(std::size_t row, const std::string& complaint) const {
    throw InputError(
        fmt::format("{}:{}: {}.", table_.file().string(), table_.line(row), complaint));
  }

  void find_columns() {
    particle_ = required_column(table_, columns::particle).column;
    right_ = axis(required_column(table_, columns::right));
    choose_vertical();
    // Ours and users' have both angles in one column; two would be said by find_column.
    if (const auto found = find_column(table_, columns::direction)) {
      angle_ = found;
    } else if (const auto ellipse = find_column(table_, columns::ellipse_direction)) {
      angle_ = ellipse;
      if (downwards_) angle_->unit.in_si *= -1.0;
    }
    find_origin();
  }

  // A picture's height is told by y. Where there is a z as well, it is the depth of the picture if
  // it never changes, and the height if y never does.
  void choose_vertical() {
    const auto y = find_column(table_, columns::vertical);
    const auto z = find_column(table_, columns::height);
    if (!y) {
      vertical_ = axis(required_column(table_, columns::height));
      if (source_.y_is_up) {
        throw InputError(
            fmt::format("{}: y_axis is stated, but the file has no column y; its z grows upwards.",
                        table_.file().string()));
      }
      return;
    }
    if (z && !is_constant(z->column)) {
      if (!is_constant(y->column)) {
        throw InputError(fmt::format(
            "{}: columns '{}' and '{}' both change; leave out the one that is the depth.",
            table_.file().string(),
            y->column,
            z->column));
      }
      vertical_ = axis(*z);
      return;
    }
    vertical_ = axis(*y);
    downwards_ = !source_.y_is_up.value_or(false);
    result_.numbered_by_place = false;
  }

  bool is_constant(const std::string& column) const {
    std::vector<double> values = table_.numbers(column);
    std::erase_if(values, [](double value) { return std::isnan(value); });
    return std::all_of(
        values.begin(), values.end(), [&](double value) { return value == values.front(); });
  }

  Axis axis(const QuantityColumn& found) const {
    if (!columns::is_in_pixels(found.unit)) return {found.column, found.unit.in_si, false};
    if (!source_.scale) {
      throw InputError(
          fmt::format("{}: column '{}' is in pixels; give the replicate scale_px_per_mm, or name "
                      "the column's unit in the file.",
                      table_.file().string(),
                      found.column));
    }
    return {found.column, 1.0 / *source_.scale, true};
  }

  void find_origin() {
    if (source_.origin_px && !source_.scale) {
      throw InputError(
          fmt::format("{}: origin_px needs scale_px_per_mm beside it.", table_.file().string()));
    }
    if (source_.scale && !right_.in_pixels && !source_.origin_px) {
      throw InputError(
          fmt::format("{}: a scale in pixels is given, but column '{}' is not in pixels; leave out "
                      "scale_px_per_mm.",
                      table_.file().string(),
                      right_.column));
    }
    if (source_.origin_px) {
      origin_ = {(*source_.origin_px)[0] / *source_.scale,
                 (*source_.origin_px)[1] / *source_.scale};
    } else if (source_.origin) {
      origin_ = *source_.origin;
    } else if (right_.in_pixels) {
      throw InputError(
          fmt::format("{}: column '{}' is in pixels; give the replicate origin_px = [x, y], where "
                      "the rig's origin lies in the picture.",
                      table_.file().string(),
                      right_.column));
    }
  }

  // Rows of one frame share its time. Of a picture's tracks what the laboratory says of the frame
  // rate counts most, then the file's own times, then the camera's frame rate.
  void find_frames() {
    std::optional<QuantityColumn> frame = find_column(table_, columns::frame);
    double first = 0.0;
    if (!frame) {
      frame = find_column(table_, columns::slice);
      first = 1.0;
    }
    const auto time = find_column(table_, columns::time);
    const bool stated = source_.frame_rate && !result_.numbered_by_place;
    const bool by_rate = frame && (stated || !time);
    if (!frame && !time) required_column(table_, columns::time);
    const double rate = source_.frame_rate.value_or(source_.usual_frame_rate);
    if (by_rate && !(rate > 0.0)) {
      throw InputError(fmt::format(
          "{}: column '{}' counts frames; give the replicate frame_rate_hz, or the file a column "
          "time_s.",
          table_.file().string(),
          frame->column));
    }
    const std::string& key = frame ? frame->column : time->column;
    std::map<double, double> time_of_key;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const double value = by_rate ? (table_.number(row, frame->column) - first) / rate
                                   : table_.number(row, time->column) * time->unit.in_si;
      const double at = table_.number(row, key);
      if (!std::isfinite(value) || !std::isfinite(at)) {
        fail(row,
             fmt::format("a cell of column '{}' is empty",
                         by_rate || !std::isfinite(at) ? key : time->column));
      }
      time_of_key.emplace(at, value - source_.event_time);
      keys_.push_back(at);
    }
    for (const auto& [at, when] : time_of_key) {
      if (!times_.empty() && !(when > times_.back())) {
        throw InputError(fmt::format("{}: column '{}' does not grow with '{}': {} s at {}.",
                                     table_.file().string(),
                                     time ? time->column : key,
                                     key,
                                     when,
                                     at));
      }
      frame_of_key_[at] = times_.size();
      times_.push_back(when);
    }
    if (!by_rate) compare_clocks(time->column, frame ? &time_of_key : nullptr);
  }

  // TrackMate and ImageJ write one second a frame where a film has no clock.
  void note_missing_clock(const std::string& time, const std::map<double, double>& frames) {
    const bool is_one_second = std::all_of(frames.begin(), frames.end(), [&](const auto& frame) {
      const auto& [number, when] = frame;
      return when - frames.begin()->second == number - frames.begin()->first;
    });
    if (!is_one_second) return;
    result_.notes.push_back(fmt::format(
        "{}: by column '{}' there is one frame a second, which is also what is written for a film "
        "without a clock; if that is so, give the replicate frame_rate_hz.",
        table_.file().string(),
        time));
  }

  // The file's own clock beside the frame rate that is stated. `frames` are the times of the
  // frames, where the file numbers them. One of the two is wrong if they part by more than a frame
  // over the recording. A nominal rate may be off by 0.2 %: 29.97 Hz are called 30.
  void compare_clocks(const std::string& time, const std::map<double, double>* frames) {
    constexpr double nominal = 2e-3;
    const double rate = source_.frame_rate.value_or(source_.usual_frame_rate);
    if (times_.size() < 2) return;
    if (!(rate > 0.0)) {
      if (frames && !result_.numbered_by_place) note_missing_clock(time, *frames);
      return;
    }
    const double duration = times_.back() - times_.front();
    double counted = 0.0;  // frames that the recording has by the file
    if (frames) {
      counted = frames->rbegin()->first - frames->begin()->first;
    } else {
      // Not every frame need be in the file: each step is the nearest whole number of frames.
      for (std::size_t i = 1; i < times_.size(); ++i)
        counted += std::round((times_[i] - times_[i - 1]) * rate);
    }
    const double expected = duration * rate;
    const double every = counted / static_cast<double>(times_.size() - 1);
    if (std::abs(expected - counted) > std::max(1.0, nominal * expected)) {
      throw InputError(fmt::format(
          "{}: by column '{}' the file has {:.4g} frames a second, but the stated frame_rate_hz is "
          "{:.4g}; give the replicate the frame_rate_hz that is right.",
          table_.file().string(),
          time,
          static_cast<double>(frames ? counted : times_.size() - 1.0) / duration,
          rate));
    }
    if (!frames && every >= 1.5) {
      result_.notes.push_back(fmt::format(
          "{}: by column '{}' there is a place every {:.4g} s, so only every {:.3g}th frame of "
          "{:.4g} Hz would be in the file. If it holds every frame, its clock is wrong: give the "
          "replicate frame_rate_hz and the file a column frame.",
          table_.file().string(),
          time,
          duration / static_cast<double>(times_.size() - 1),
          every,
          rate));
    }
  }

  void find_particles() {
    std::map<int, std::size_t> index_of_number;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const int number = table_.integer(row, particle_);
      if (result_.numbered_by_place && number < 1) {
        fail(row,
             fmt::format("column '{}' holds {}; particles are numbered from 1", particle_, number));
      }
      numbers_.push_back(number);
      index_of_number.emplace(number, 0);
    }
    std::size_t next = 0;
    for (auto& [number, index] : index_of_number)
      index = result_.numbered_by_place ? static_cast<std::size_t>(number - 1) : next++;
    particles_ = result_.numbered_by_place ? index_of_number.rbegin()->first
                                           : static_cast<int>(index_of_number.size());
    refuse_sparse(index_of_number.size());
    for (int& number : numbers_) number = static_cast<int>(index_of_number.at(number));
  }

  // Room is made for every number up to the highest, in every frame.
  void refuse_sparse(std::size_t known) const {
    constexpr std::size_t most_unseen = 1000;  // numbers for each that is there
    if (static_cast<std::size_t>(particles_) <= most_unseen * known) return;
    throw InputError(
        fmt::format("{}: column '{}' goes up to {}, but holds only {} different numbers; number "
                    "particles from 1 on without large gaps.",
                    table_.file().string(),
                    particle_,
                    particles_,
                    known));
  }

  std::optional<Axis> error_axis(const Quantity& quantity) const {
    auto found = find_column(table_, quantity);
    if (!found) found = find_column(table_, columns::either_error);
    if (!found) return std::nullopt;
    return axis(*found);
  }

  // What is seen has an uncertainty above 0, where the file tells any.
  void require_uncertainty(std::size_t row,
                           const std::string& column,
                           double uncertainty,
                           double value) const {
    if (!std::isfinite(value) || (std::isfinite(uncertainty) && uncertainty > 0.0)) return;
    fail(row,
         fmt::format(
             "column '{}' is {}, but an uncertainty above 0 is needed in every row. Write it, "
             "or leave the whole column out",
             column,
             std::isnan(uncertainty) ? "empty" : table_.text(row, column)));
  }

  void fill() {
    const auto right_error = error_axis(columns::right_error);
    const auto vertical_error = error_axis(columns::height_error);
    const auto angle_error = find_column(table_, columns::direction_error);
    const bool uncertain = right_error && vertical_error;
    if (!uncertain && (right_error || vertical_error || angle_error)) {
      throw InputError(
          fmt::format("{}: column '{}' tells an uncertainty, but not that of both coordinates; "
                      "give sigma_x and sigma_z, or ep for both, or leave it out.",
                      table_.file().string(),
                      right_error      ? right_error->column
                      : vertical_error ? vertical_error->column
                                       : angle_error->column));
    }
    const bool scored = table_.has("score");
    result_.tracks = make_trajectories(times_.size(), particles_, uncertain);
    Trajectories& tracks = result_.tracks;
    tracks.time = times_;
    std::vector<int> line_of(tracks.poses.size(), 0);
    const double sign = downwards_ ? -1.0 : 1.0;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const std::size_t i =
          tracks.index(frame_of_key_.at(keys_[row]), static_cast<std::size_t>(numbers_[row]));
      if (line_of[i] != 0) {
        fail(
            row,
            fmt::format("particle {} is there a second time at {} s (first in line {}); a particle "
                        "is in one place at a time",
                        table_.text(row, particle_),
                        number_text(tracks.time[frame_of_key_.at(keys_[row])]),
                        line_of[i]));
      }
      line_of[i] = table_.line(row);
      const auto metres = [&](const Axis& axis) {
        return table_.number(row, axis.column) * axis.metres;
      };
      for (const Axis* axis : {&right_, &vertical_}) {
        if (std::isinf(metres(*axis)))
          fail(row, fmt::format("column '{}' holds no finite number", axis->column));
      }
      tracks.poses[i] = {metres(right_) - origin_[0],
                         sign * (metres(vertical_) - origin_[1]),
                         angle_ ? table_.number(row, angle_->column) * angle_->unit.in_si : nan};
      if (!uncertain) continue;
      tracks.sigmas[i] = {
          metres(*right_error),
          metres(*vertical_error),
          angle_error ? table_.number(row, angle_error->column) * angle_error->unit.in_si : nan};
      require_uncertainty(row, right_error->column, tracks.sigmas[i].x, tracks.poses[i].x);
      require_uncertainty(row, vertical_error->column, tracks.sigmas[i].z, tracks.poses[i].z);
      if (angle_error)
        require_uncertainty(
            row, angle_error->column, tracks.sigmas[i].angle, tracks.poses[i].angle);
      tracks.scores[i] = scored ? table_.number(row, "score") : 1.0;
    }
  }

  const Table& table_;
  const TrackSource& source_;
  ReadTracks result_;
  std::string particle_;
  Axis right_, vertical_;
  bool downwards_ = false;
  std::optional<QuantityColumn> angle_;
  std::array<double, 2> origin_ = {0.0, 0.0};  // m, from the file's own
  std::vector<double> keys_;                   // of each row: its frame, or its time
  std::map<double, std::size_t> frame_of_key_;
  std::vector<double> times_;  // s, from the event; one a frame
  std::vector<int> numbers_;   // of each row: the index of its particle
  int particles_ = 0;
};

}  // namespace

ReadTracks read_track_file(const std::filesystem::path& file, const TrackSource& source) {
  const Table table =
      is_xml(file) ? read_trackmate_xml(file) : without_trackmate_headers(read_csv(file));
  return TrackReader(table, source).read();
}

Trajectories read_tracks(const std::filesystem::path& file) { return read_track_file(file).tracks; }

}  // namespace graintruth::datasets
