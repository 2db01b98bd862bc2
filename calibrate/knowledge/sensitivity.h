// Which parameters the objective depends on, over the whole box.
#pragma once

#include <vector>

#include "calibrate/search/surrogate.h"

namespace graintruth::calibrate {

// Total Sobol index of every coordinate, 0 to 1: the share of the variance of the surrogate's mean
// over the unit cube that would be left if all others were known (Homma and Saltelli 1996; Saltelli
// 2002). Of the logarithm of the objective, because that is what the surrogate is of.
std::vector<double> total_sensitivities(const Surrogate& surrogate, std::size_t dimension);

}  // namespace graintruth::calibrate
