// A quantity of the user's own: a column of a table beside each replicate, and the curve that the
// engine records of the same. In time it is compared moment by moment. A table without time has one
// number, which is compared with one number of the curve.
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/compare/repeated_rule.h"
#include "calibrate/observables/curve_observable.h"
#include "calibrate/observables/moments.h"
#include "calibrate/observables/observable.h"
#include "datasets/store/toml_section.h"

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The value of a curve at a moment t is its mean over the time around t,
//   1/2h integral of q from t - h to t + h,
// of the straight lines q between its samples. So it does not depend on where the samples lie or
// how many they are. h is half an interval, and less where the event or the end of the curve is
// nearer: what comes before the event is another motion.
struct Window {
  double from, to;
};

Window window_around(double time, double interval, const datasets::Curve& curve) {
  const double begin = std::max(0.0, curve.time.front());
  const double half =
      std::max(0.0, std::min({0.5 * interval, time - begin, curve.time.back() - time}));
  return {time - half, time + half};
}

struct Value {
  double value, sigma;
};

// Mean over the window, or the value at its one moment; the first and the last line go on where a
// curve begins or ends less than a sample too late or early. The uncertainties of the samples are
// taken as independent.
Value mean_over(const datasets::Curve& curve, Window window) {
  const auto& time = curve.time;
  if (time.size() == 1)
    return {curve.value.front(), curve.sigma.empty() ? nan : curve.sigma.front()};
  const auto after = static_cast<std::size_t>(
      std::upper_bound(time.begin(), time.end(), window.from) - time.begin());
  const double length = window.to - window.from;
  double sum = 0.0, squares = 0.0;
  const auto take = [&](std::size_t sample, double share) {
    sum += share * curve.value[sample];
    if (!curve.sigma.empty()) squares += std::pow(share * curve.sigma[sample], 2);
  };
  double share_of_left = 0.0;  // from the line before
  for (std::size_t left = std::clamp<std::size_t>(after, 1, time.size() - 1) - 1;; ++left) {
    // Mean of a straight line: its value at the middle
    const double from = std::max(window.from, time[left]);
    const double to = std::min(window.to, time[left + 1]);
    const double share = length > 0.0 ? (to - from) / length : 1.0;
    const double middle = length > 0.0 ? 0.5 * (from + to) : window.from;
    const double right = (middle - time[left]) / (time[left + 1] - time[left]);
    take(left, share_of_left + share * (1.0 - right));
    share_of_left = share * right;
    if (left + 2 == time.size() || time[left + 1] >= window.to) {
      take(left + 1, share_of_left);
      return {sum, curve.sigma.empty() ? nan : std::sqrt(squares)};
    }
  }
}

Channel at_moments(const datasets::Curve& curve,
                   const std::vector<double>& times,
                   double interval) {
  Channel channel;
  for (const double time : times) {
    const Value value = mean_over(curve, window_around(time, interval, curve));
    channel.values.push_back(value.value);
    channel.errors.push_back(value.sigma);
  }
  return channel;
}

double root_of_squares(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares);
}

// One number of a curve in time, up to the last moment.
Channel number_of(const datasets::Curve& curve,
                  CurveNumber number,
                  const std::vector<double>& times,
                  double interval) {
  if (number == CurveNumber::end) return at_moments(curve, {times.back()}, interval);
  if (number == CurveNumber::mean) {
    const Channel moments = at_moments(curve, times, interval);
    const auto count = static_cast<double>(times.size());
    double sum = 0.0;
    for (const double value : moments.values) sum += value;
    return {.values = {sum / count}, .errors = {root_of_squares(moments.errors) / count}};
  }
  Channel largest{.values = {nan}, .errors = {nan}};
  for (std::size_t i = 0; i < curve.time.size(); ++i) {
    if (curve.time[i] < 0.0 || curve.time[i] > times.back() + 0.5 * interval) continue;
    if (curve.value[i] <= largest.values.front()) continue;
    largest.values.front() = curve.value[i];
    largest.errors.front() = curve.sigma.empty() ? nan : curve.sigma[i];
  }
  return largest;
}

}  // namespace

std::vector<double> CurveObservable::axis(const Situation& situation) const {
  return measurement_times(situation.measurement.frame_interval, situation.measurement.frames);
}

Channel CurveObservable::measure(const datasets::Recording& recording,
                                 const Situation& situation,
                                 const Channel* like) const {
  // The column of a replicate, or the curve of an engine
  auto found = recording.curves.find(curve_.column);
  if (found == recording.curves.end()) found = recording.curves.find(curve_.engine_curve);
  if (found == recording.curves.end()) return {};
  const datasets::Curve& curve = found->second;
  if (curve.time.empty()) {
    Channel channel{.values = {curve.value.front()}};
    if (!curve.sigma.empty()) channel.errors = {curve.sigma.front()};
    return channel;
  }
  const double interval = situation.measurement.frame_interval;
  if (!spans(curve.time, situation.measurement.last_time())) return {};
  if (curve_.number || (like && like->values.size() == 1))
    return number_of(curve, curve_.number.value_or(CurveNumber::end), axis(situation), interval);
  return at_moments(curve, axis(situation), interval);
}

std::unique_ptr<Rule> CurveObservable::rule(const RuleParts& parts) const {
  auto of = parts.of(name());
  if (!of) return nullptr;
  if (of->replicates.front().values.size() > 1) {
    return std::make_unique<RepeatedRule>(of->channel,
                                          ChannelShape{.widths = Widths::own_replicates},
                                          parts.form,
                                          *parts.layout,
                                          std::move(of->replicates));
  }
  return std::make_unique<PooledRule>(
      of->channel,
      ChannelShape{},
      [](const Channel&) { return std::vector<double>{0.0}; },
      *parts.layout,
      std::move(of->replicates));
}

std::string CurveObservable::lacking_words() const {
  return "a column '" + curve_.column +
         "' in the table of curves of every replicate, to the last "
         "moment";
}

std::optional<CurveNumber> read_curve_number(datasets::TomlSection& settings) {
  const auto at = settings.optional_text("at");
  if (!at) return std::nullopt;
  if (*at == "end") return CurveNumber::end;
  if (*at == "mean") return CurveNumber::mean;
  if (*at == "largest") return CurveNumber::largest;
  settings.fail("at", "must be \"end\", \"mean\" or \"largest\"");
}

namespace {

std::shared_ptr<const Observable> make(const datasets::Experiment&,
                                       datasets::TomlSection* settings) {
  OwnCurve curve;
  const std::string& section = settings->name();
  curve.name = section.substr(section.rfind('.') + 1);
  curve.column = settings->optional_text("column").value_or(curve.name);
  curve.engine_curve = settings->text("engine_curve");
  curve.unit = settings->text("unit");
  curve.title = settings->optional_text("title").value_or(curve.name);
  curve.number = read_curve_number(*settings);
  return std::make_shared<CurveObservable>(std::move(curve));
}

}  // namespace

extern constinit const ObservableKind own_curve_kind{.name = "own", .make = make};

}  // namespace graintruth::calibrate
