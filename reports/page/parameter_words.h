// A parameter of result.json in words, the same wherever the page mentions it.
#pragma once

#include <string>

#include "reports/page/run_data.h"

namespace graintruth::reports {

// Whether it stands at its bench value.
bool is_at_bench(const Json& parameter);

// Its value, to the digits that its interval gives sense to; as the laboratory stated it where it
// is held at that; to two digits where nothing says how well it is known.
std::string value_text(const Json& parameter);

// "0.10 to 0.14"; `nothing` where it has no interval, and in place of an end that was not found.
std::string interval_of(const Json& parameter);

// What is known of it: "tuned", "open above", "budget ended", "not identified", "at bound",
// "given".
std::string status_words(const Json& parameter);

// Whether its value means nothing: the data do not determine it, or the budget ended before they
// could. A verdict shows a dash in its place.
bool is_undetermined(const Json& parameter);

}  // namespace graintruth::reports
