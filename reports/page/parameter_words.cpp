#include "reports/page/parameter_words.h"

#include <fmt/format.h>

#include <cmath>

#include "reports/page/words.h"

namespace graintruth::reports {

bool is_at_bench(const Json& parameter) {
  return std::abs(number(parameter, {"value"}) - number(parameter, {"bench_value"})) < 1.0e-9;
}

std::string value_text(const Json& parameter) {
  const double lower = number(parameter, {"lower"});
  const double upper = number(parameter, {"upper"});
  const double value = number(parameter, {"value"});
  if (std::isfinite(lower) && std::isfinite(upper)) return to_interval(value, lower, upper);
  const bool is_of_the_search = text(parameter, {"status"}) == "not_identified";
  return is_of_the_search && !is_at_bench(parameter) ? significant(value, 2) : plain(value);
}

namespace {

// Runs of older versions do not say how an end came about.
bool is_found(const Json& parameter, const char* end) {
  const std::string kind = text(parameter, {end});
  return kind.empty() || kind == "found";
}

// Nothing lies below 0.
bool has_lower_end(const Json& parameter) {
  const bool is_limit =
      text(parameter, {"lower_end"}) == "open" && number(parameter, {"lower"}) <= 0.0;
  return is_limit || is_found(parameter, "lower_end");
}

}  // namespace

std::string interval_of(const Json& parameter) {
  const double lower = number(parameter, {"lower"}), upper = number(parameter, {"upper"});
  const bool has_lower = has_lower_end(parameter), has_upper = is_found(parameter, "upper_end");
  if (has_lower && has_upper) return interval_text(lower, upper);
  if (!std::isfinite(lower) || !std::isfinite(upper) || (!has_lower && !has_upper))
    return std::string(nothing);
  return fmt::format("{} to {}",
                     has_lower ? to_interval(lower, lower, upper) : std::string(nothing),
                     has_upper ? to_interval(upper, lower, upper) : std::string(nothing));
}

std::string status_words(const Json& parameter) {
  const std::string status = text(parameter, {"status"});
  if (status.empty()) return std::string(nothing);
  if (status == "not_identified") return "not identified";
  if (status == "at_bound") return "at bound";
  if (status == "fixed") return "given";
  const std::string interval = text(parameter, {"interval_status"});
  return interval.empty() || interval == "found" ? spaced(status) : spaced(interval);
}

bool is_undetermined(const Json& parameter) {
  const std::string status = text(parameter, {"status"});
  if (status == "not_identified") return interval_of(parameter) == nothing;
  return status == "tuned" && text(parameter, {"interval_status"}) == "budget_ended" &&
         interval_of(parameter) == nothing;
}

}  // namespace graintruth::reports
