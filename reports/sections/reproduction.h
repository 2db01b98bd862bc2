// The page of graintruth reproduce: what the thesis claims and prints, with a verdict for each.
#pragma once

#include <string>

#include "reports/page/run_data.h"

namespace graintruth::reports {

bool is_reproduction(const RunData& data);
std::string build_reproduction_page(const RunData& data);

}  // namespace graintruth::reports
