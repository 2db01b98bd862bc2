// Where the next simulations are best spent.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "calibrate/search/emulator.h"

namespace graintruth::calibrate {

// What is improved upon: the lowest total so far, of an objective and what is `known` everywhere (a
// prior's penalty; may be empty). Differences below `floor` are noise. A place that has `crowd`
// evaluations around it is left alone: in a valley of chance, where neighbours differ by what no
// emulator can foresee, every place promises to be better than the last.
struct Aim {
  double lowest = 0.0;
  double floor = 0.0;
  std::function<double(const UnitPoint&)> known;
  int crowd = std::numeric_limits<int>::max();
};

// `count` places to be evaluated at once, each the one of largest expected improvement of the
// total's logarithm (Mockus 1975; Jones, Schonlau and Welch 1998) when those before it are believed
// to turn out as predicted; fewer where everything is crowded. Looked for over the whole cube and,
// ever finer, around `centres`. The same for the same arguments.
std::vector<UnitPoint> propose(const Emulator& emulator,
                               const Aim& aim,
                               const std::vector<UnitPoint>& centres,
                               int count,
                               std::uint64_t seed);

}  // namespace graintruth::calibrate
