#include "calibrate/search/reach.h"

#include <algorithm>
#include <limits>

namespace graintruth::calibrate {

double share_out_of_reach(const Comparison& comparison, std::span<const Evaluation> evaluations) {
  constexpr double inside = 1.0;  // a residual of one is the end of the replicates' interval
  std::vector<double> lowest, highest;
  for (const Evaluation& evaluation : evaluations) {
    const std::vector<double> z = comparison.residuals(evaluation.runs);
    if (z.empty()) continue;
    if (lowest.empty()) lowest = highest = z;
    for (std::size_t i = 0; i < z.size(); ++i) {
      lowest[i] = std::min(lowest[i], z[i]);
      highest[i] = std::max(highest[i], z[i]);
    }
  }
  if (lowest.empty()) return std::numeric_limits<double>::quiet_NaN();
  double missed = 0.0;
  for (std::size_t i = 0; i < lowest.size(); ++i)
    missed += lowest[i] > inside || highest[i] < -inside ? 1.0 : 0.0;
  return missed / static_cast<double>(lowest.size());
}

}  // namespace graintruth::calibrate
