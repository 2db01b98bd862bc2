// The flow rates of Tables 4.4 and 4.5, as the fits take them.
#pragma once

#include <string>
#include <vector>

#include "app/thesis/thesis_data.h"
#include "calibrate/flow/beverloo.h"

namespace graintruth::app {

// Of the table of this name, for particles of the given diameter (m).
std::vector<calibrate::DischargeRate> printed_rates(const ThesisData& thesis,
                                                    const std::string& name,
                                                    double diameter);

}  // namespace graintruth::app
