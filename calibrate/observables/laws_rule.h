// The constants of the two laws of a discharging bed, compared between experiment and simulation:
// Beverloo's C and k from the rates of all conditions, the kinematic B from each condition's
// velocity profile. What the thesis compares its films and simulations by (Tables 4.4 to 4.7).
#pragma once

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/flow/flow_laws.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

enum class Law { beverloo, kinematic };

// Null where no constants fit the replicates: Beverloo's law needs two orifices through which
// grains flow and how densely the bed lies, the kinematic model a profile.
std::unique_ptr<Rule> make_laws_rule(Law law, const RuleParts& parts);

}  // namespace graintruth::calibrate
