#include "calibrate/knowledge/calibrated_parameter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/parameters/parameter.h"

namespace graintruth::calibrate {

namespace {

constexpr double confidence_95 = 1.96;
constexpr double conflicting = 2.0;  // combined standard uncertainties

std::string text_of(const datasets::BenchValue& known) {
  return fmt::format("{:.3g} +- {:.2g}", known.value, known.standard_uncertainty);
}

}  // namespace

std::string_view name_of(ParameterStatus status) {
  switch (status) {
    case ParameterStatus::tuned:
      return "tuned";
    case ParameterStatus::fixed:
      return "fixed";
    case ParameterStatus::at_bound:
      return "at_bound";
    case ParameterStatus::not_identified:
      return "not_identified";
  }
  return "";
}

bool is_unfinished(const CalibratedParameter& parameter) {
  return parameter.status == ParameterStatus::tuned && parameter.lower_end != EndKind::found &&
         parameter.upper_end != EndKind::found;
}

std::string_view interval_status(const CalibratedParameter& parameter) {
  if (parameter.status == ParameterStatus::fixed) return "given";
  if (parameter.status == ParameterStatus::not_identified) return "not_determined";
  if (parameter.lower_end == EndKind::search_ended || parameter.upper_end == EndKind::search_ended)
    return name_of(EndKind::search_ended);
  if (parameter.lower_end == EndKind::open && parameter.lower_bound > 0.0) return "open_below";
  return parameter.upper_end == EndKind::open ? "open_above" : "found";
}

Interval prior_interval(const CalibratedParameter& parameter) {
  const double half = confidence_95 * parameter.prior->standard_uncertainty;
  const auto inside = [&](double value) {
    return std::clamp(value, parameter.lower_bound, parameter.upper_bound);
  };
  return {inside(parameter.prior->value - half), inside(parameter.prior->value + half)};
}

std::optional<double> deviation_from(const CalibratedParameter& parameter,
                                     const datasets::BenchValue& known) {
  if (!parameter.data_alone) return std::nullopt;
  const auto& [value, interval, below, above] = *parameter.data_alone;
  if ((known.value < value ? below : above) != EndKind::found) return 0.0;
  const double side = known.value < value ? value - interval.lower : interval.upper - value;
  const double combined = std::hypot(side / confidence_95, known.standard_uncertainty);
  return combined > 0.0 ? (value - known.value) / combined : 0.0;
}

bool is_in_conflict(const CalibratedParameter& parameter) {
  return parameter.prior &&
         std::abs(deviation_from(parameter, *parameter.prior).value_or(0.0)) > conflicting;
}

std::string words_on_conflict(const CalibratedParameter& parameter) {
  const DataAlone& data = *parameter.data_alone;
  const std::string_view reason = datasets::parameter_named(parameter.name).kind->bench_differs;
  return fmt::format(
      "{}: The data alone give {:.3g} ({:.3g} to {:.3g}) and the prior {}. They differ by {:.1f} "
      "combined standard uncertainties, so the value is a compromise; {}.",
      parameter.name,
      data.value,
      data.interval.lower,
      data.interval.upper,
      text_of(*parameter.prior),
      std::abs(*deviation_from(parameter, *parameter.prior)),
      reason);
}

std::string words_on_unidentified(const CalibratedParameter& parameter,
                                  std::span<const CalibratedParameter> all) {
  std::string held = fmt::format("it is held at {} {:.3g}",
                                 std::abs(parameter.value - parameter.bench) < 1.0e-9
                                     ? "its bench value"
                                     : "the value that fits best,",
                                 parameter.value);
  const bool shows_alone = parameter.effect > parameter.effect_noise;
  if (parameter.prior && !parameter.shows_effect) {
    held = fmt::format("its value and interval are the prior's, {}", text_of(*parameter.prior));
  } else if (parameter.interval) {
    std::vector<std::string> priors;
    for (const CalibratedParameter& other : all) {
      if (other.prior) priors.push_back(other.name);
    }
    held =
        fmt::format("its value and interval rest on the prior of {}", fmt::join(priors, " and "));
  }
  if (shows_alone) {
    return fmt::format(
        "{} is not identified: on its own it moves the objective by up to {:.3g}, but every value "
        "of it fits as well once the other parameters follow it; {}.",
        parameter.name,
        parameter.effect,
        held);
  }
  return fmt::format(
      "{} is not identified: over its full range the objective moves by {:.3g}, and other "
      "replicates and seeds alone could move it by {:.3g}; {}.",
      parameter.name,
      parameter.effect,
      parameter.effect_noise,
      held);
}

std::string words_on_search_end(const CalibratedParameter& parameter, const std::string& limit) {
  const bool lower = parameter.lower_end == EndKind::search_ended,
             upper = parameter.upper_end == EndKind::search_ended;
  if (parameter.status == ParameterStatus::not_identified || (!lower && !upper)) return "";
  return fmt::format(
      "{} ended before {} of {} was found; until it is, the interval reaches to the bound of the "
      "search. This is no word of the data.",
      limit,
      lower && upper ? "either end of the interval"
      : lower        ? "the lower end of the interval"
                     : "the upper end of the interval",
      parameter.name);
}

std::string words_on_dominance(const CalibratedParameter& parameter) {
  if (!parameter.prior || !parameter.data_alone) return "";
  const Interval& data = parameter.data_alone->interval;
  const Interval prior = prior_interval(parameter);
  if (prior.upper - prior.lower >= data.upper - data.lower) return "";
  return fmt::format(
      "The interval of {} comes more from the prior ({}) than from the data. The data alone give "
      "{:.3g} to {:.3g}.",
      parameter.name,
      text_of(*parameter.prior),
      data.lower,
      data.upper);
}

}  // namespace graintruth::calibrate
