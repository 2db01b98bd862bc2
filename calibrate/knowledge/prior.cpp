#include "calibrate/knowledge/prior.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/parameters.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {

namespace {

constexpr double half_chi_squared = 1.92;  // chi-squared(0.95, 1) / 2

}  // namespace

double log_likelihood(double objective, double allowed) {
  return -half_chi_squared * objective / allowed;
}

Prior::Prior(std::vector<datasets::TunedParameter> tuned) : tuned_(std::move(tuned)) {
  std::erase_if(tuned_, [](const auto& parameter) { return !parameter.prior; });
}

bool Prior::is_stated() const { return !tuned_.empty(); }

double Prior::penalty(const ParameterSet& parameters) const {
  if (!is_weighed()) return 0.0;
  double squares = 0.0;
  for (const datasets::TunedParameter& tuned : tuned_) {
    const double deviation = value_of(parameters, tuned.name) - tuned.prior->value;
    squares += std::pow(deviation / tuned.prior->standard_uncertainty, 2);
  }
  return allowed_ / (2.0 * half_chi_squared) * squares;
}

double Prior::reach(const datasets::TunedParameter& parameter, double excess) const {
  if (!is_weighed() || !parameter.prior) return std::numeric_limits<double>::infinity();
  return parameter.prior->standard_uncertainty *
         std::sqrt(2.0 * half_chi_squared * std::max(0.0, excess) / allowed_);
}

}  // namespace graintruth::calibrate
