// How many values of a profile can differ by chance of their own, where neighbours vary together.
#pragma once

#include <span>
#include <vector>

namespace graintruth::calibrate {

// A profile's values over repeats; all profiles have the same number of values.
using Repeats = std::vector<std::vector<double>>;

// (tr C)^2 / tr C^2, C the covariances of what repeats deviate from the mean of their own group, in
// units of each value's own scatter (Bretherton et al. 1999, J. Climate 12, 1990). Of few repeats
// it is at most their degrees of freedom. Values that never vary, or are not known in all repeats
// of a group, add nothing to it. 1 where nothing varies, or no group has two repeats.
double independent_values(std::span<const Repeats> groups);

}  // namespace graintruth::calibrate
