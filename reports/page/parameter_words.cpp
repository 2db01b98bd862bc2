#include "reports/page/parameter_words.h"

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

std::string interval_of(const Json& parameter) {
  return interval_text(number(parameter, {"lower"}), number(parameter, {"upper"}));
}

}  // namespace graintruth::reports
