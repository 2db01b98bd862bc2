// One parameter as a calibration leaves it, and what must be said of it in words.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "calibrate/knowledge/uncertainty.h"

namespace graintruth::calibrate {

// What the data say: tuned, at the edge of its bounds, or not identified by them; whatever a prior
// adds. Fixed: not asked. A parameter whose interval the search had no budget to find is tuned:
// that is no word of the data, see is_unfinished().
enum class ParameterStatus { tuned, fixed, at_bound, not_identified };
std::string_view name_of(ParameterStatus status);

// What the data say of a parameter without any prior.
struct DataAlone {
  double value = 0.0;
  Interval interval;  // 95 %
  EndKind below = EndKind::found;
  EndKind above = EndKind::found;
};

struct CalibratedParameter {
  std::string name;
  double value = 0.0;
  // 95 %, priors included; none where fixed, or where neither data nor priors tell
  std::optional<Interval> interval;
  EndKind lower_end = EndKind::found;  // of the interval
  EndKind upper_end = EndKind::found;
  ParameterStatus status = ParameterStatus::fixed;
  double bench = 0.0;
  double bench_uncertainty = 0.0;  // standard; 0 where none is given
  std::optional<datasets::BenchValue> prior;
  std::optional<DataAlone> data_alone;  // none where the data do not identify it
  double lower_bound = 0.0;             // of the search
  double upper_bound = 0.0;
  bool shows_effect = false;  // on the data, at either end of its range
  double effect = 0.0;        // change of the data's objective at the worse end of its range
  double effect_noise = 0.0;  // what other replicates and seeds could explain of it
  double sobol_total = std::numeric_limits<double>::quiet_NaN();  // see sensitivity.h
};

// Whether the search ended before either end of its interval was found.
bool is_unfinished(const CalibratedParameter& parameter);

// What is known of its interval, in one word for files: "found", "open_below" or "open_above"
// (every value up to that bound of the search fits as well), "budget_ended" (the search ended
// before both ends were found), "not_determined" (the data cannot tell it; an interval rests on a
// prior), "given". An end at 0 is no open one: nothing lies beyond.
std::string_view interval_status(const CalibratedParameter& parameter);

// The 95 % interval of its prior, m +- 1.96 u, as far as it lies between the bounds. Needs a prior.
Interval prior_interval(const CalibratedParameter& parameter);

// How far what the data alone ask for lies from what is known otherwise, b - m in combined standard
// uncertainties sqrt(s^2 + u^2): s is a 1.96th of the data's interval on the side of m. 0 where the
// interval is open on that side; nothing where the data do not identify the parameter.
std::optional<double> deviation_from(const CalibratedParameter& parameter,
                                     const datasets::BenchValue& known);

// Whether data and prior contradict each other: farther than 2 combined standard uncertainties.
bool is_in_conflict(const CalibratedParameter& parameter);

// One sentence each. `all` are all parameters, because an interval may rest on another's prior.
std::string words_on_conflict(const CalibratedParameter& parameter);
std::string words_on_unidentified(const CalibratedParameter& parameter,
                                  std::span<const CalibratedParameter> all);
// Where the search ended before an end of its interval was found; empty elsewhere. `limit` is what
// ended it: "The budget of 20 evaluations".
std::string words_on_search_end(const CalibratedParameter& parameter, const std::string& limit);
// Where the prior is narrower than what the data alone give; empty elsewhere.
std::string words_on_dominance(const CalibratedParameter& parameter);

}  // namespace graintruth::calibrate
