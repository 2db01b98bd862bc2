// The median of values; NaN where there is none.
#pragma once

#include <vector>

namespace graintruth::calibrate {

double median(std::vector<double> values);

}  // namespace graintruth::calibrate
