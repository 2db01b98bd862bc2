#include "calibrate/observables/profile_number.h"

#include "calibrate/compare/pooled_rule.h"

namespace graintruth::calibrate {

std::unique_ptr<Rule> ProfileNumber::rule(const RuleParts& parts) const {
  auto of = parts.of(name());
  if (!of) return nullptr;
  return std::make_unique<PooledRule>(
      of->channel,
      ChannelShape{},
      [](const Channel&) { return std::vector<double>{at_rest}; },
      *parts.layout,
      std::move(of->replicates));
}

}  // namespace graintruth::calibrate
