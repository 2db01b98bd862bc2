// Where a surrogate says that the next simulations are best spent.
#pragma once

#include <cstdint>
#include <vector>

#include "calibrate/surrogate.h"

namespace graintruth::calibrate {

// `count` places to be evaluated at once, each the one of largest expected improvement over the
// surrogate's lowest mean (Mockus 1975; Jones, Schonlau and Welch 1998, eq 15) when those before it
// are believed to turn out as predicted. Looked for over the whole cube and, ever finer, around
// `centres`. The same for the same arguments.
std::vector<UnitPoint> propose(const Surrogate& surrogate,
                               const std::vector<UnitPoint>& centres,
                               int count,
                               std::uint64_t seed);

}  // namespace graintruth::calibrate
