// The median that robust estimates rest on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace graintruth::tracking {

// The middle value; of an even number the upper of the two in the middle. `of_none` where there are
// no values.
template <class Number>
Number median(std::vector<Number> values, Number of_none = Number{}) {
  if (values.empty()) return of_none;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace graintruth::tracking
