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

// Mean of what was recorded within half an interval of each moment, and its standard uncertainty;
// between samples by a straight line where there are none so near.
Channel at_moments(const datasets::Curve& curve,
                   const std::vector<double>& times,
                   double interval) {
  Channel channel;
  for (const double time : times) {
    double sum = 0.0, squares = 0.0;
    int count = 0;
    std::size_t after = 0;
    for (std::size_t i = 0; i < curve.time.size(); ++i) {
      if (curve.time[i] < time) after = i + 1;
      if (std::abs(curve.time[i] - time) > 0.5 * interval) continue;
      sum += curve.value[i];
      if (!curve.sigma.empty()) squares += curve.sigma[i] * curve.sigma[i];
      ++count;
    }
    if (count > 0) {
      channel.values.push_back(sum / count);
      channel.errors.push_back(curve.sigma.empty() ? nan : std::sqrt(squares) / count);
    } else if (after > 0 && after < curve.time.size()) {
      const double share =
          (time - curve.time[after - 1]) / (curve.time[after] - curve.time[after - 1]);
      channel.values.push_back(curve.value[after - 1] +
                               share * (curve.value[after] - curve.value[after - 1]));
      channel.errors.push_back(curve.sigma.empty() ? nan : curve.sigma[after]);
    } else {
      channel.values.push_back(nan);
      channel.errors.push_back(nan);
    }
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
