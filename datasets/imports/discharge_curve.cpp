#include "datasets/imports/discharge_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>

#include "datasets/imports/balance_readings.h"
#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

constexpr double tolerated_share = 0.02;  // of all mass; as straight as a steady stretch must be
constexpr std::size_t fewest_rows = 5;    // with fewer no stretch of a curve is a line
constexpr double grams = 1e3;             // in a kilogram

// Values of one column in SI, and what one must be multiplied with to be the mass that has left.
struct MassColumn {
  QuantityColumn column;
  double kilograms = 1.0;
  bool is_of_what_remains() const { return kilograms < 0.0; }
};

MassColumn find_mass(const Table& table, const DischargeSource& source) {
  const auto per_unit = [&](const QuantityColumn& column) {
    return columns::is_a_weight(column.unit) ? 1.0 / source.gravity : 1.0;
  };
  if (const auto share = find_column(table, columns::discharged_share))
    return {*share, source.full_mass};
  if (const auto remaining = find_column(table, columns::remaining_mass))
    return {*remaining, -per_unit(*remaining)};
  const QuantityColumn discharged = required_column(table, columns::discharged_mass);
  return {discharged, per_unit(discharged)};
}

class CurveReader {
 public:
  CurveReader(const Table& table, const DischargeSource& source)
      : table_(table),
        source_(source),
        time_(required_column(table, columns::time)),
        mass_(find_mass(table, source)),
        tolerance_(std::max(tolerated_share * source.full_mass, source.particle_mass)) {}

  const std::vector<std::string>& notes() const { return notes_; }

  DischargeCurve read() {
    read_rows();
    leave_out_spikes();
    leave_out_stuck();
    take_out_tare();
    judge();
    smooth();
    return std::move(curve_);
  }

 private:
  [[noreturn]] void fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}: {}.", table_.file().string(), complaint));
  }
  [[noreturn]] void fail(std::size_t row, const std::string& complaint) const {
    throw InputError(
        fmt::format("{}:{}: {}.", table_.file().string(), table_.line(row), complaint));
  }
  void note(const std::string& sentence) {
    notes_.push_back(fmt::format("{}: {}.", table_.file().string(), sentence));
  }
  const std::string& column() const { return mass_.column.column; }
  int line_of(const Reading& reading) const { return table_.line(reading.row); }
  // In the sense of the column, which may tell what remains.
  double as_written(double left) const { return mass_.is_of_what_remains() ? -left : left; }

  void read_rows() {
    if (table_.rows() < fewest_rows) {
      fail(fmt::format(
          "a discharge curve needs at least {} rows, this has {}", fewest_rows, table_.rows()));
    }
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const double when = table_.number(row, time_.column) * time_.unit.in_si - source_.event_time;
      const double value = table_.number(row, column()) * mass_.column.unit.in_si * mass_.kilograms;
      for (const auto& [number, name] : {std::pair(when, time_.column), std::pair(value, column())})
        if (!std::isfinite(number))
          fail(row,
               fmt::format("a cell of column '{}' is empty or no finite number. Write the reading, "
                           "or remove the row",
                           name));
      if (row == 0 && when > 0.0) {
        fail(row,
             fmt::format("the curve begins {:.3g} s after the start event. The mass that left "
                         "before is not known. Start the recording before the event, or correct "
                         "event_s",
                         when));
      }
      if (row > 0 && !(when > readings_.back().time)) {
        fail(row,
             fmt::format("column '{}' does not rise: {} after {}. Times must rise from row to row; "
                         "correct the clock, or remove the row",
                         time_.column,
                         table_.text(row, time_.column),
                         table_.text(row - 1, time_.column)));
      }
      readings_.push_back({when, value, row});
    }
    if (!(readings_.back().time > 0.0)) {
      fail(
          fmt::format("the curve ends before the start event at {} s of its clock; correct event_s",
                      source_.event_time));
    }
  }

  // How many readings stand before the event or at it.
  std::size_t rest() const {
    return static_cast<std::size_t>(
        std::find_if(readings_.begin(),
                     readings_.end(),
                     [](const Reading& reading) { return reading.time > 0.0; }) -
        readings_.begin());
  }
  std::span<const Reading> at_rest() const { return std::span(readings_).first(rest()); }
  std::span<const Reading> after_event() const { return std::span(readings_).subspan(rest()); }

  void leave_out_spikes() {
    constexpr std::size_t always = 3, one_in = 50;
    const std::vector<Spike> spikes = find_spikes(readings_, source_.particle_mass);
    if (spikes.empty()) return;
    double largest = 0.0;
    for (const Spike& spike : spikes) largest = std::max(largest, std::abs(spike.off));
    const std::string what = fmt::format(
        "{} of {} readings of column '{}' stand out from their neighbours, the first "
        "in line {}, by up to {:.3g} g",
        spikes.size(),
        readings_.size(),
        column(),
        line_of(readings_[spikes.front().place]),
        grams * largest);
    if (spikes.size() > std::max(always, readings_.size() / one_in))
      fail(what + ". So many are no chance; look at the cell and its cable, or remove the rows");
    note(what + ". They are left out");
    for (auto spike = spikes.rbegin(); spike != spikes.rend(); ++spike)
      readings_.erase(readings_.begin() + static_cast<std::ptrdiff_t>(spike->place));
  }

  void leave_out_stuck() {
    const std::vector<Stuck> runs = find_stuck(readings_, rest(), source_.particle_mass);
    for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
      const bool is_at_end = run->last + 1 == readings_.size();
      note(fmt::format(
          "column '{}' is stuck at {} from line {} to line {}{}. These readings are "
          "left out{}",
          column(),
          table_.text(readings_[run->first].row, column()),
          line_of(readings_[run->first]),
          line_of(readings_[run->last]),
          is_at_end
              ? std::string()
              : fmt::format(", and then makes a step of {:.3g} g", grams * as_written(run->jump)),
          is_at_end ? "; what left after that is not known" : ""));
      const auto first = readings_.begin() + static_cast<std::ptrdiff_t>(run->first) + 1;
      readings_.erase(first, first + static_cast<std::ptrdiff_t>(run->last - run->first));
    }
    std::reverse(notes_.end() - static_cast<std::ptrdiff_t>(runs.size()), notes_.end());
    if (!(readings_.back().time > 0.0))
      fail(fmt::format("column '{}' is stuck from before the start event to the end", column()));
  }

  // The level at rest, and its drift; what is left of each reading is what has left the bin.
  void take_out_tare() {
    const std::span<const Reading> resting = at_rest();
    const double after = readings_.back().time;
    // A drift that moves the count of particles, or what is tolerated, by a tenth
    const double matters =
        std::max(0.5 * source_.particle_mass, 0.1 * tolerated_share * source_.full_mass);
    const double rest_lasts = -resting.front().time;
    // A stated event that lies in the flow makes a rest that moves as fast as what follows
    constexpr double share_of_flow = 0.25;
    const Tare tare = find_tare(resting,
                                matters / std::max(0.5 * rest_lasts, after),
                                share_of_flow * fastest_rate(after_event()));
    drift_ = tare.drift;
    // Two standard errors at the end of the curve
    const bool holds_on = 2.0 * tare.drift_standard_error * after <= matters;
    if (tare.drift != 0.0) {
      const double rate = grams * as_written(tare.drift);
      const std::string what = fmt::format(
          "column '{}' drifts by {:.3g} g/s in the {:.3g} s of rest before the start event",
          column(),
          rate,
          rest_lasts);
      note(holds_on
               ? fmt::format("{}. The drift is taken out of the whole curve: {:.3g} g at its end",
                             what,
                             rate * after)
               : fmt::format("{}. It is taken out up to the event only, because it is not known "
                             "well enough for the {:.3g} s that follow. It may add {:.3g} g by "
                             "their end",
                             what,
                             after,
                             rate * after));
    }
    say_what_stands_out_at_rest(tare, noise_of(resting));
    for (Reading& reading : readings_) {
      const double until = holds_on ? reading.time : std::min(reading.time, 0.0);
      reading.mass -= tare.level + tare.drift * until;
    }
  }

  // Of readings before the last that is not above the tare; what comes later may have left.
  void say_what_stands_out_at_rest(const Tare& tare, double noise) {
    const double limit = std::max(8.0 * noise, source_.particle_mass);
    std::size_t count = 0, first = 0;
    double largest = 0.0;
    const std::size_t settled = settled_at_rest(tare);
    for (std::size_t i = 0; i < settled; ++i) {
      const double off = std::abs(readings_[i].mass - tare.level - tare.drift * readings_[i].time);
      if (!(off > limit)) continue;
      if (count++ == 0) first = i;
      largest = std::max(largest, off);
    }
    if (count == 0) return;
    note(
        fmt::format("{} of {} readings of column '{}' before the start event lie off the others, "
                    "the first in line {}, by up to {:.3g} g. The tare is the median of all, which "
                    "they hardly move",
                    count,
                    rest(),
                    column(),
                    line_of(readings_[first]),
                    grams * largest));
  }

  // How many readings there are up to the last at rest that is not above the tare: in all of them
  // nothing has left.
  std::size_t settled_at_rest(const Tare& tare) const {
    std::size_t settled = rest();
    while (settled > 1 &&
           readings_[settled - 1].mass - tare.drift * readings_[settled - 1].time > tare.level)
      --settled;
    return settled;
  }

  // A stretch of readings after the event, as long as makes the noise small.
  struct Stretch {
    double left = 0.0;      // kg, median
    std::size_t first = 0;  // row of the table
  };

  std::vector<Stretch> stretches() {
    constexpr double sigmas = 8.0, efficiency = 1.2533;  // of a median beside a mean
    constexpr std::size_t least_number = 10;
    const std::span<const Reading> after = after_event();
    const double noise = std::max(noise_of(at_rest()), noise_of(after));
    const double wanted = std::ceil(std::pow(sigmas * efficiency * noise / tolerance_, 2));
    const auto length = static_cast<std::size_t>(
        std::clamp(wanted, 1.0, std::max(1.0, static_cast<double>(after.size() / least_number))));
    // Where there are too few readings for that
    if (wanted > static_cast<double>(length))
      tolerance_ = sigmas * efficiency * noise / std::sqrt(static_cast<double>(length));
    std::vector<Stretch> result;
    for (std::size_t first = 0; first < after.size(); first += length) {
      std::vector<double> masses;
      for (std::size_t i = first; i < std::min(first + length, after.size()); ++i)
        masses.push_back(after[i].mass);
      result.push_back({boost::math::statistics::median(masses), after[first].row});
    }
    return result;
  }

  void judge() {
    const std::vector<Stretch> all = stretches();
    double highest = 0.0;
    for (const Stretch& stretch : all) highest = std::max(highest, stretch.left);
    // 1. The opposite of what the column's name says
    if (all.back().left < -tolerance_ && highest < tolerance_) {
      const bool remains = mass_.is_of_what_remains();
      fail(
          fmt::format("column '{}' {} by {:.4g} g after the start event, as the mass {} does. Call "
                      "it {}",
                      column(),
                      remains ? "rises" : "falls",
                      -grams * all.back().left,
                      remains ? "that has left" : "still in the bin",
                      remains ? "discharged_mass_g" : "remaining_mass_g"));
    }
    // 2. What cannot be
    highest = 0.0;
    for (const Stretch& stretch : all) {
      if (stretch.left < highest - tolerance_) {
        fail(
            stretch.first,
            fmt::format("column '{}' says that {:.4g} g have left, but {:.4g} g had left before. "
                        "The mass that has left cannot fall. Remove the rows from where the "
                        "balance was touched, emptied or set to zero{}",
                        column(),
                        grams * stretch.left,
                        grams * highest,
                        drift_ == 0.0 ? std::string()
                                      : fmt::format(", or take out its drift, which was {:.3g} g/s "
                                                    "before the start event",
                                                    grams * as_written(drift_))));
      }
      highest = std::max(highest, stretch.left);
      if (highest > source_.full_mass + tolerance_) {
        fail(stretch.first,
             fmt::format("column '{}' says that {:.4g} g have left, but all particles weigh {:.4g} "
                         "g; look at the column's unit, particle.count and particle.mass_g",
                         column(),
                         grams * highest,
                         grams * source_.full_mass));
      }
    }
    if (highest < source_.particle_mass) {
      fail(
          fmt::format("no mass leaves: column '{}' {} by {:.3g} g after the start event, but one "
                      "particle weighs {:.3g} g; look at the column's unit and at event_s",
                      column(),
                      mass_.is_of_what_remains() ? "falls" : "rises",
                      grams * highest,
                      grams * source_.particle_mass));
    }
  }

  void smooth() {
    // Up to there nothing has left
    const std::size_t settled = settled_at_rest({});
    std::vector<double> masses;
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      curve_.time.push_back(readings_[i].time);
      masses.push_back(i < settled ? 0.0 : readings_[i].mass);
    }
    curve_.mass = never_falling(masses);
    const double before = curve_.mass[rest() - 1];
    if (before > tolerance_) {
      note(
          fmt::format("{:.3g} g have left before the start event at {:.4g} s of the file's clock; "
                      "correct event_s",
                      grams * before,
                      source_.event_time));
    }
  }

  const Table& table_;
  const DischargeSource& source_;
  QuantityColumn time_;
  MassColumn mass_;
  double tolerance_;    // kg, that the mass may fall back
  double drift_ = 0.0;  // kg/s, at rest
  Readings readings_;
  DischargeCurve curve_;
  std::vector<std::string> notes_;
};

}  // namespace

DischargeCurve read_discharge_curve(const std::filesystem::path& file,
                                    const DischargeSource& source,
                                    std::vector<std::string>* notes) {
  const Table table = read_csv(file);
  CurveReader reader(table, source);
  DischargeCurve curve = reader.read();
  if (notes) {
    notes->insert(notes->end(), table.notes().begin(), table.notes().end());
    notes->insert(notes->end(), reader.notes().begin(), reader.notes().end());
  }
  return curve;
}

}  // namespace graintruth::datasets
